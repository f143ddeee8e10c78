//! Records the operations of a run on files and directories, and works out what a power failure between two of them may leave.
//!
//! The content of a file is certain once the file is synced, and a name once its directory is synced. Before that each may be there or
//! not: a later name may survive an earlier one, and a file may have its name and a part of its content, zeros or nothing.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// An operation that has been carried out.
#[derive(Clone, Debug)]
pub enum Operation {
    Create(PathBuf, u64),
    CreateDirectory(PathBuf),
    Write { file: u64, place: u64, bytes: Vec<u8> },
    Cut { file: u64, length: u64 },
    Sync(u64),
    SyncDirectory(PathBuf),
    Rename(PathBuf, PathBuf),
    Exchange(PathBuf, PathBuf),
    Link(PathBuf, PathBuf),
    Remove(PathBuf),
}

/// The operations below a directory.
struct Log {
    root: PathBuf,
    operations: Vec<Operation>,
}

static LOG: Mutex<Option<Log>> = Mutex::new(None);
/// Held while a test records.
static TURN: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &'static Mutex<T>) -> MutexGuard<'static, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Records the operations below `root` that `work` carries out, in all threads.
pub fn record(root: &Path, work: impl FnOnce()) -> Vec<Operation> {
    let _turn = lock(&TURN);
    *lock(&LOG) = Some(Log { root: root.to_owned(), operations: Vec::new() });
    work();
    lock(&LOG).take().map_or(Vec::new(), |log| log.operations)
}

fn note(path: Option<&Path>, operation: impl FnOnce() -> Operation) {
    if let Some(log) = lock(&LOG).as_mut()
        && path.is_none_or(|path| path.starts_with(&log.root))
    {
        log.operations.push(operation());
    }
}

fn number(file: &File) -> u64 {
    file.metadata().map_or(0, |found| found.ino())
}

pub fn created(path: &Path, file: &File) {
    note(Some(path), || Operation::Create(path.to_owned(), number(file)));
}

pub fn created_directory(path: &Path) {
    note(Some(path), || Operation::CreateDirectory(path.to_owned()));
}

pub fn wrote(file: &File, place: u64, bytes: &[u8]) {
    note(None, || Operation::Write { file: number(file), place, bytes: bytes.to_vec() });
}

pub fn cut(file: &File, length: u64) {
    note(None, || Operation::Cut { file: number(file), length });
}

pub fn synced(file: &File) {
    note(None, || Operation::Sync(number(file)));
}

pub fn synced_directory(path: &Path) {
    note(Some(path), || Operation::SyncDirectory(path.to_owned()));
}

pub fn renamed(from: &Path, to: &Path) {
    note(Some(from), || Operation::Rename(from.to_owned(), to.to_owned()));
}

pub fn exchanged(a: &Path, b: &Path) {
    note(Some(a), || Operation::Exchange(a.to_owned(), b.to_owned()));
}

pub fn linked(from: &Path, to: &Path) {
    note(Some(from), || Operation::Link(from.to_owned(), to.to_owned()));
}

pub fn removed(path: &Path) {
    note(Some(path), || Operation::Remove(path.to_owned()));
}

/// Files with their contents, and directories.
pub type Tree = BTreeMap<PathBuf, Option<Vec<u8>>>;

/// Returns what is below a directory. Paths count from the directory.
pub fn tree(root: &Path) -> Tree {
    fn add(root: &Path, inside: &Path, all: &mut Tree) {
        for entry in fs::read_dir(root.join(inside)).unwrap() {
            let path = inside.join(entry.unwrap().file_name());
            if root.join(&path).is_dir() {
                all.insert(path.clone(), None);
                add(root, &path, all);
            } else {
                all.insert(path.clone(), Some(fs::read(root.join(&path)).unwrap()));
            }
        }
    }
    let mut all = Tree::new();
    add(root, Path::new(""), &mut all);
    all
}

/// Makes the files and directories of a tree in an empty directory.
pub fn make(root: &Path, tree: &Tree) {
    for (path, content) in tree {
        match content {
            None => fs::create_dir(root.join(path)).unwrap(),
            Some(bytes) => fs::write(root.join(path), bytes).unwrap(),
        }
    }
}

type Names = BTreeMap<String, usize>;

#[derive(Clone, Debug)]
enum Node {
    File { now: Vec<u8>, certain: Vec<u8> },
    Directory { now: Names, certain: Names },
}

/// Names that change together: directory, name, and what has the name then.
type Change = Vec<(usize, String, Option<usize>)>;

/// A disk on which the operations are carried out again.
pub struct Disk {
    root: PathBuf,
    nodes: Vec<Node>,
    of_number: BTreeMap<u64, usize>,
    /// Changes of names that are not certain yet.
    pending: Vec<Change>,
}

/// Chooses one of so many outcomes of an operation that is not synced: a number below the argument.
pub type Choice<'a> = &'a mut dyn FnMut(usize) -> usize;

impl Disk {
    /// Returns a disk with everything that is below `root`, certainly.
    pub fn of(root: &Path) -> Self {
        let empty = Node::Directory { now: Names::new(), certain: Names::new() };
        let mut disk =
            Self { root: root.to_owned(), nodes: vec![empty], of_number: BTreeMap::new(), pending: Vec::new() };
        for (path, content) in tree(root) {
            let path = root.join(path);
            match content {
                None => disk.apply(&Operation::CreateDirectory(path)),
                Some(bytes) => {
                    let file = fs::metadata(&path).unwrap().ino();
                    disk.apply(&Operation::Create(path, file));
                    disk.apply(&Operation::Write { file, place: 0, bytes });
                    disk.apply(&Operation::Sync(file));
                }
            }
        }
        for node in &mut disk.nodes {
            if let Node::Directory { now, certain } = node {
                certain.clone_from(now);
            }
        }
        disk.pending.clear();
        disk
    }

    fn find(&self, path: &Path) -> usize {
        path.strip_prefix(&self.root).unwrap().components().fold(0, |directory, part| {
            let Node::Directory { now, .. } = &self.nodes[directory] else {
                panic!("no directory: {}", path.display())
            };
            now[part.as_os_str().to_str().unwrap()]
        })
    }

    fn place(&self, path: &Path) -> (usize, String) {
        (self.find(path.parent().unwrap()), path.file_name().unwrap().to_str().unwrap().to_owned())
    }

    fn add(&mut self, path: &Path, node: Node) -> usize {
        self.nodes.push(node);
        let number = self.nodes.len() - 1;
        let (directory, name) = self.place(path);
        self.change(vec![(directory, name, Some(number))]);
        number
    }

    fn change(&mut self, change: Change) {
        for (directory, name, to) in &change {
            let Node::Directory { now, .. } = &mut self.nodes[*directory] else { panic!("no directory") };
            set(now, name, *to);
        }
        self.pending.push(change);
    }

    fn content(&mut self, number: u64) -> Option<(&mut Vec<u8>, &mut Vec<u8>)> {
        match &mut self.nodes[*self.of_number.get(&number)?] {
            Node::File { now, certain } => Some((now, certain)),
            Node::Directory { .. } => None,
        }
    }

    /// Carries out an operation.
    pub fn apply(&mut self, operation: &Operation) {
        match operation {
            Operation::Create(path, number) => {
                let node = self.add(path, Node::File { now: Vec::new(), certain: Vec::new() });
                self.of_number.insert(*number, node);
            }
            Operation::CreateDirectory(path) => {
                self.add(path, Node::Directory { now: Names::new(), certain: Names::new() });
            }
            Operation::Write { file, place, bytes } => {
                let Some((now, _)) = self.content(*file) else { return };
                let start = usize::try_from(*place).unwrap();
                now.resize(now.len().max(start + bytes.len()), 0);
                now[start..start + bytes.len()].copy_from_slice(bytes);
            }
            Operation::Cut { file, length } => {
                if let Some((now, _)) = self.content(*file) {
                    now.resize(usize::try_from(*length).unwrap(), 0);
                }
            }
            Operation::Sync(file) => {
                if let Some((now, certain)) = self.content(*file) {
                    certain.clone_from(now);
                }
            }
            Operation::SyncDirectory(path) => {
                let synced = self.find(path);
                let pending = std::mem::take(&mut self.pending);
                for change in pending {
                    if change.iter().any(|(directory, ..)| *directory == synced) {
                        keep(&mut self.nodes, &change);
                    } else {
                        self.pending.push(change);
                    }
                }
            }
            Operation::Rename(from, to) => {
                let node = self.find(from);
                let (a, old) = self.place(from);
                let (b, new) = self.place(to);
                self.change(vec![(a, old, None), (b, new, Some(node))]);
            }
            Operation::Exchange(a, b) => {
                let one = self.find(a);
                let other = self.find(b);
                let (a, first) = self.place(a);
                let (b, second) = self.place(b);
                self.change(vec![(a, first, Some(other)), (b, second, Some(one))]);
            }
            Operation::Link(from, to) => {
                let node = self.find(from);
                let (directory, name) = self.place(to);
                self.change(vec![(directory, name, Some(node))]);
            }
            Operation::Remove(path) => {
                let (directory, name) = self.place(path);
                self.change(vec![(directory, name, None)]);
            }
        }
    }

    /// Returns what is there now, as a process sees it.
    pub fn now(&self) -> Tree {
        let mut all = Tree::new();
        add(&self.nodes, 0, Path::new(""), &mut all, &mut |now, _| now.to_vec());
        all
    }

    /// Returns what a power failure may leave. `names` chooses which of the uncertain changes of names are kept (1), `contents` what an
    /// uncertain file holds: 0: what is certain; 1: all; 2: zeros behind what is certain; 3: the first half.
    pub fn after_power_failure(&self, names: Choice, contents: Choice) -> Tree {
        let mut nodes = self.nodes.clone();
        for change in &self.pending {
            if names(2) == 1 {
                keep(&mut nodes, change);
            }
        }
        for node in &mut nodes {
            if let Node::Directory { now, certain } = node {
                now.clone_from(certain);
            }
        }
        let mut all = Tree::new();
        add(&nodes, 0, Path::new(""), &mut all, &mut |now, certain| {
            let common = now.iter().zip(certain).take_while(|(a, b)| a == b).count();
            match if now == certain { 1 } else { contents(4) } {
                0 => certain.to_vec(),
                1 => now.to_vec(),
                2 => [&now[..common], &vec![0; now.len() - common]].concat(),
                _ => now[..usize::midpoint(common, now.len())].to_vec(),
            }
        });
        all
    }
}

fn set(names: &mut Names, name: &str, to: Option<usize>) {
    match to {
        Some(node) => names.insert(name.to_owned(), node),
        None => names.remove(name),
    };
}

/// Makes a change of names certain.
fn keep(nodes: &mut [Node], change: &Change) {
    for (directory, name, to) in change {
        let Node::Directory { certain, .. } = &mut nodes[*directory] else { panic!("no directory") };
        set(certain, name, *to);
    }
}

fn add(nodes: &[Node], node: usize, path: &Path, all: &mut Tree, of: &mut dyn FnMut(&[u8], &[u8]) -> Vec<u8>) {
    match &nodes[node] {
        Node::File { now, certain } => {
            all.insert(path.to_owned(), Some(of(now, certain)));
        }
        Node::Directory { now, .. } => {
            if node != 0 {
                all.insert(path.to_owned(), None);
            }
            for (name, &node) in now {
                add(nodes, node, &path.join(name), all, of);
            }
        }
    }
}
