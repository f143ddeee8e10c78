use std::fs;

use super::*;

fn header(dimension: u8) -> Header {
    Header {
        format: 1,
        version: String::new(),
        scene: String::new(),
        title: String::new(),
        dimension,
        species: Vec::new(),
        periodic: [Some((0.0, 2.0)), None, None],
        domain: [[0.0; 3], [2.0, 1.0, 0.0]],
        walls: Vec::new(),
        columns: Vec::new(),
    }
}

fn column(name: &str, components: u8, values: Values) -> Column {
    Column { name: name.to_owned(), unit: String::new(), components, values }
}

/// One disc, with a column that no format knows.
fn frame() -> Frame {
    let columns = vec![
        column("id", 1, Values::U32(vec![7])),
        column("species", 1, Values::U8(vec![2])),
        column("radius", 1, Values::F64(vec![0.25])),
        column("mass", 1, Values::F64(vec![4.0])),
        column("position", 2, Values::F64(vec![0.1, 1e-30])),
        column("velocity", 2, Values::F64(vec![3.0, -4.0])),
        column("heat flow", 2, Values::F64(vec![1.0 / 3.0, 8.0])),
    ];
    let table = Table { name: "grains".to_owned(), rows: 1, columns };
    Frame { step: 9, time: 0.5, tables: vec![table], ..Frame::default() }
}

/// The columns of [`frame`].
fn all() -> Columns {
    Columns::of(std::iter::once(Ok(frame()))).unwrap()
}

#[test]
fn xyz_has_every_column_with_all_digits() {
    let expected = "1\n\
        Lattice=\"2e0 0e0 0e0 0e0 1e0 0e0 0e0 0e0 5e-1\" Origin=\"0e0 0e0 -2.5e-1\" \
        Properties=id:I:1:type:I:1:pos:R:3:radius:R:1:mass:R:1:velo:R:2:heat_flow:R:2:kinetic_energy:R:1 Time=5e-1 Step=9 \
        pbc=\"T F F\"\n\
        7 2 1e-1 1e-30 0e0 2.5e-1 4e0 3e0 -4e0 3.333333333333333e-1 8e0 5e1\n";
    assert_eq!(xyz::text(&header(2), &frame()), expected);
}

#[test]
fn dump_has_every_column_with_all_digits() {
    let expected = "ITEM: TIME\n5e-1\nITEM: TIMESTEP\n9\nITEM: NUMBER OF ATOMS\n1\n\
        ITEM: BOX BOUNDS pp ff ff\n0e0 2e0\n0e0 1e0\n-2.5e-1 2.5e-1\n\
        ITEM: ATOMS id type radius mass x y z vx vy heat_flow[1] heat_flow[2] kinetic_energy\n\
        7 3 2.5e-1 4e0 1e-1 1e-30 0e0 3e0 -4e0 3.333333333333333e-1 8e0 5e1\n";
    assert_eq!(dump::text(&header(2), &frame()), expected);
}

#[test]
fn an_export_that_fails_leaves_nothing() {
    let [here, run] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    for (name, format) in Target::ALL.into_iter().filter(|(_, format)| format.is_available()) {
        let frames = [Ok(frame()), Err(io::Error::other("torn"))];
        let error =
            export(format, &header(2), &all(), frames.into_iter(), run.path(), &here.path().join(name)).unwrap_err();
        assert_eq!(error.to_string(), "torn", "{name}");
        let count =
            export(format, &header(2), &all(), std::iter::once(Ok(frame())), run.path(), &here.path().join(name))
                .unwrap();
        assert_eq!(count, 1);
        assert!(here.path().join(name).exists());
    }
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), if cfg!(feature = "parquet") { 5 } else { 4 });
}

#[test]
fn csv_has_a_row_for_each_grain_and_frame_with_all_digits() {
    let [here, run] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    let target = here.path().join("csv");
    let later = Frame { step: 10, time: 0.75, ..frame() };
    let frames = [frame(), later].into_iter().map(Ok);
    assert_eq!(export(Target::Csv, &header(2), &all(), frames, run.path(), &target).unwrap(), 2);
    let row = "7,2,2.5e-1,4e0,1e-1,1e-30,3e0,-4e0,3.333333333333333e-1,8e0,5e1";
    let expected = format!(
        "time_s,step,id,species,radius,mass,position_x,position_y,velocity_x,velocity_y,heat flow_x,heat flow_y,kinetic_energy\n\
         5e-1,9,{row}\n7.5e-1,10,{row}\n"
    );
    assert_eq!(fs::read_to_string(target.join("grains.csv")).unwrap(), expected);
    assert_eq!(fs::read_dir(target).unwrap().count(), 1);
}
