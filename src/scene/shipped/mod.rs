//! The scenes that come with the program, for `siloflow scenes` and `siloflow new`: they are there without a clone of the
//! repository.

use std::path::Path;

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Shipped {
    /// Name: that of its file in `scenes`, without the ending.
    pub name: &'static str,
    /// Content in one line.
    pub line: &'static str,
    /// The scene.
    pub text: &'static str,
    /// The file that the scene names, if any: the path in the scene, and the content.
    pub input: Option<(&'static str, &'static str)>,
}

macro_rules! scene {
    ($name:literal, $line:literal) => {
        Shipped {
            name: $name,
            line: $line,
            text: include_str!(concat!("../../../scenes/", $name, ".ron")),
            input: None,
        }
    };
    ($name:literal, $line:literal, $input:literal) => {
        Shipped { input: Some(($input, include_str!(concat!("../../../scenes/", $input)))), ..scene!($name, $line) }
    };
}

/// All shipped scenes: silos first, then cases of verification.
pub const SCENES: [Shipped; 33] = [
    scene!("silo1", "a silo with an insert, 1000 discs: fill, rest, door opens, empty", "../assets/silo1.dat"),
    scene!("silo1-mixture", "the same silo, half of the grains with radius 4 cm, half 3 cm", "../assets/silo1.dat"),
    scene!("silo1-polydisperse", "the same silo, radii from 3 to 5 cm", "../assets/silo1.dat"),
    scene!(
        "silo1-literal",
        "the same silo with k and b read in SI: grains fall through the walls",
        "../assets/silo1.dat"
    ),
    scene!("silo1-one-column", "the same silo without jitter: grains stack up exactly", "../assets/silo1.dat"),
    scene!("silo2d", "5214 frictional discs in a mass-flow silo, with their velocity field", "../assets/silo2d.dat"),
    scene!("gated-bin", "a hopper in the plane whose gate opens and shuts three times"),
    scene!("silo3d", "10,000 frictional spheres in a wedge hopper with a slot"),
    scene!("round-silo", "3000 frictional spheres in a cylinder with a cone and a circular outlet"),
    scene!("fed-hopper", "a round hopper of parametric dimensions, fed at a rate, then discharged"),
    scene!("rice-silo", "500 grains of rice, rigid bodies of seven spheres, in a round silo"),
    scene!("drum", "300 frictional spheres in a rotating drum with lifters"),
    scene!("bed3d", "a periodic bed of 10,000 frictional spheres"),
    scene!("chute3d", "spheres flow down a rough incline, periodic sides"),
    scene!("couette", "discs sheared between rough walls"),
    scene!("shear-cell", "a shear cell in the plane: discs between plates with bars, under a loaded lid"),
    scene!("yield-locus", "a point of a yield locus: sticky discs, consolidated and sheared under a smaller load"),
    scene!("wall-friction", "discs sheared against a smooth plate under a loaded lid"),
    scene!("compression", "uniaxial compression of 600 spheres in a smooth cylinder"),
    scene!("heap", "angle of repose: a cylinder of 656 spheres is lifted"),
    scene!("draw-down", "1500 discs flow out of a slot: a heap below, slopes above"),
    scene!("drum-angle", "dynamic angle of 950 spheres in a rotating drum"),
    scene!("outlet", "does an outlet of 4.5 diameters clog?"),
    scene!("drop", "a sphere falls on a plate and jumps"),
    scene!("silo2d-lattice", "lattice gas in the outline of silo2d"),
    scene!("mass-flow", "lattice gas in a mass-flow silo"),
    scene!("funnel-flow", "lattice gas in a funnel-flow silo"),
    scene!("parabola", "lattice gas: one thrown particle"),
    scene!("free-fall", "one grain on a parabola", "free-fall.csv"),
    scene!("column", "a stack of 20 discs settles under its weight", "column.csv"),
    scene!("bounce-oblique", "a sphere hits a wall obliquely", "bounce-oblique.csv"),
    scene!("slip-to-roll", "a sliding sphere begins to roll", "slip-to-roll.csv"),
    scene!("stacked-pair", "two spheres between two walls", "stacked-pair.csv"),
];

/// The scene of `siloflow new`, with `@NAME@` in the place of its file.
const TEMPLATE: &str = include_str!("template.ron");

/// A file to write: its name and its content.
pub type NewFile = (String, String);

/// Returns the commented scene for a file of this name.
#[must_use]
pub fn template(file: &str) -> NewFile {
    (file.to_owned(), TEMPLATE.replace("@NAME@", file))
}

impl Shipped {
    /// Returns the scene of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        SCENES.iter().find(|scene| scene.name == name)
    }

    /// Returns a copy of the scene for a file `stem.ron`, and of the file that it names, as `stem` with its own ending.
    #[must_use]
    pub fn copy(&self, stem: &str) -> Vec<NewFile> {
        let file = format!("{stem}.ron");
        let Some((path, content)) = self.input else { return vec![(file, self.text.to_owned())] };
        let ending = Path::new(path).extension().unwrap_or_default().display();
        let input = format!("{stem}.{ending}");
        let scene = self.text.replace(&format!("\"{path}\""), &format!("{input:?}"));
        vec![(file, scene), (input, content.to_owned())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    #[test]
    fn all_scenes_of_the_repository_are_listed() {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let files = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
        let mut there: Vec<_> = files
            .filter(|path| path.extension().is_some_and(|ending| ending == "ron"))
            .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        there.sort();
        let mut listed: Vec<_> = SCENES.iter().map(|scene| scene.name.to_owned()).collect();
        listed.sort();
        assert_eq!(listed, there);
    }

    #[test]
    fn copies_load_from_another_directory() {
        let here = tempfile::tempdir().unwrap();
        for scene in &SCENES {
            for (name, content) in scene.copy("my \"silo\"") {
                std::fs::write(here.path().join(name), content).unwrap();
            }
            load::any(&here.path().join("my \"silo\".ron"), &[])
                .unwrap_or_else(|fault| panic!("{}: {fault}", scene.name));
        }
        std::fs::write(here.path().join("new.ron"), template("new.ron").1).unwrap();
        load::any(&here.path().join("new.ron"), &[]).unwrap();
    }
}
