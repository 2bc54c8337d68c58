use super::*;
use crate::shape::FaceMaterials;
use std::cell::Cell;
use std::io::Write;
use tempfile::TempDir;

/// All that an entry holds: materials, libraries, attributes with and without indices of their own, findings, an origin.
const TEXT: &str = "mtllib a b.mtl\nv 1000000 0 0\nv 1000001 0 0\nv 1000001 1 0\nv 1000000 1 0.5\nv 1 x 2\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 0 0\nf 1/1/1 2/2/1 3/3/1\nusemtl caf\u{e9} one\nf 1/3/1 3/1 4/2/1\n\
    f 1 2 99\nf 1 2\nusemtl two\nf 2//1 4 3\nl 1 2\n";

const LIMITS: [u64; 2] = [1, 2];

fn mesh_file(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("mesh.obj");
    fs::write(&path, text).unwrap();
    path
}

fn parse(text: &str, name: &Path) -> ObjFile {
    let options = crate::load::obj::ReadOptions::default();
    crate::load::obj::read_from(text.as_bytes(), name, None, &options).unwrap()
}

/// The mesh through the cache, and whether its file was read.
fn through(cache: &Cache, path: &Path) -> (ObjFile, bool) {
    let was_read = Cell::new(false);
    let read = || {
        was_read.set(true);
        Ok(parse(&fs::read_to_string(path).unwrap(), path))
    };
    let mesh = cache.through((path, &File::open(path).unwrap()), &LIMITS, &|_| true, read).unwrap();
    (mesh, was_read.get())
}

/// Every number and word, so that equal texts are equal bits.
fn all(mesh: &ObjFile) -> String {
    format!("{mesh:?}")
}

#[test]
fn what_comes_out_is_what_went_in() {
    let folder = TempDir::new().unwrap();
    let cache = Cache::open(&folder.path().join("new/cache")).unwrap();
    for text in [TEXT, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf 1//1 2//2 3//3\n"] {
        let path = mesh_file(folder.path(), text);
        let fresh = parse(text, &path);
        let (first, was_read) = through(&cache, &path);
        assert!(was_read && all(&first) == all(&fresh));
        let (second, was_read) = through(&cache, &path);
        assert!(!was_read && all(&second) == all(&fresh), "{}\n{}", all(&second), all(&fresh));
        // Another name, the same content: findings name the file that was asked for.
        let copy = folder.path().join("copy.obj");
        fs::copy(&path, &copy).unwrap();
        let (third, was_read) = through(&cache, &copy);
        assert!(!was_read && all(&third) == all(&parse(text, &copy)));
    }
    assert_eq!(cache.served(), (4, 2));
}

#[test]
fn changed_files_are_read_again() {
    let folder = TempDir::new().unwrap();
    let cache = Cache::open(folder.path()).unwrap();
    let path = mesh_file(folder.path(), TEXT);
    let modified = fs::metadata(&path).unwrap().modified().unwrap();
    assert!(through(&cache, &path).1);
    // The same length, and a program that sets the time back.
    let changed = TEXT.replace("1000001 1 0", "1000001 2 0");
    fs::write(&path, &changed).unwrap();
    File::options().write(true).open(&path).unwrap().set_modified(modified).unwrap();
    let (mesh, was_read) = through(&cache, &path);
    assert!(was_read && all(&mesh) == all(&parse(&changed, &path)));
    fs::write(&path, TEXT).unwrap();
    assert!(!through(&cache, &path).1, "what it was once is still known");
    // What was read within other limits might be refused within these.
    assert_ne!(entry::file_name(&[7; 32], &LIMITS), entry::file_name(&[7; 32], &[1, 3]));
}

/// Each flipped byte, each cut, each byte too many: told, read anew, and written anew.
#[test]
fn damage_anywhere_is_found() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("entry");
    let (content, name) = ([7; 32], Path::new("a.obj"));
    entry::write(&path, &content, &parse(TEXT, name)).unwrap();
    let whole = fs::read(&path).unwrap();
    let read = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        entry::read(&path, &content, name)
    };
    assert!(read(&whole).unwrap().is_some());
    for at in 0..whole.len() {
        for flip in [1, 0x80] {
            let mut damaged = whole.clone();
            damaged[at] ^= flip;
            assert!(read(&damaged).is_err(), "byte {at} of {}", whole.len());
        }
        assert!(read(&whole[..at]).is_err(), "cut at {at}");
    }
    assert!(read(&[whole.as_slice(), b"x"].concat()).is_err());
    read(&whole).unwrap();
    assert!(entry::read(&path, &[8; 32], name).is_err(), "another file's");
    assert!(entry::read(&folder.path().join("none"), &content, name).unwrap().is_none());
}

/// Whoever can write into the folder can also compute digests.
#[test]
fn meshes_that_break_their_promises_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("entry");
    let name = Path::new("a.obj");
    type Change = (&'static str, fn(&mut ObjFile));
    let breaks: &[Change] = &[
        ("an index", |o| o.mesh.indices[0][1] = 5),
        ("a position", |o| o.mesh.positions[0][2] = f32::NAN),
        ("a large position", |o| o.mesh.positions[0][2] = 2e18),
        ("an origin", |o| o.origin.x = f64::INFINITY),
        ("a material", |o| o.mesh.materials = FaceMaterials::Uniform(3)),
        ("materials", |o| o.mesh.materials = FaceMaterials::PerFace(vec![0, 0])),
        ("a normal's index", |o| o.mesh.normals.as_mut().unwrap().indices.as_mut().unwrap()[0][0] = 2),
        ("few indices", |o| {
            o.mesh.uvs.as_mut().unwrap().indices.as_mut().unwrap().pop();
        }),
    ];
    for (what, change) in breaks {
        let mut mesh = parse(TEXT, name);
        change(&mut mesh);
        entry::write(&path, &[7; 32], &mesh).unwrap();
        assert_eq!(entry::read(&path, &[7; 32], name).unwrap_err(), "is no sound mesh", "{what}");
    }
}

#[test]
fn an_unusable_entry_is_told_and_replaced_and_no_link_followed() {
    let folder = TempDir::new().unwrap();
    let cache = Cache::open(&folder.path().join("cache")).unwrap();
    let path = mesh_file(folder.path(), TEXT);
    let (fresh, _) = through(&cache, &path);
    let content = *blake3::hash(TEXT.as_bytes()).as_bytes();
    let entry = folder.path().join("cache").join(entry::file_name(&content, &LIMITS));
    let whole = fs::read(&entry).unwrap();
    let victim = folder.path().join("victim");
    fs::write(&victim, "precious").unwrap();
    let damages: [&dyn Fn(); 3] = [
        &|| fs::write(&entry, &whole[..whole.len() / 2]).unwrap(),
        &|| std::os::unix::fs::symlink(&victim, &entry).unwrap(),
        &|| rustix::fs::mkfifoat(rustix::fs::CWD, &entry, rustix::fs::Mode::RUSR).unwrap(),
    ];
    for damage in damages {
        fs::remove_file(&entry).unwrap();
        damage();
        let (mesh, was_read) = through(&cache, &path);
        assert!(was_read && mesh.findings.count(UNUSABLE) == 1);
        assert_eq!(format!("{:?}", mesh.mesh), format!("{:?}", fresh.mesh));
        assert!(!through(&cache, &path).1 && fs::read(&entry).unwrap() == whole);
    }
    assert_eq!(fs::read(&victim).unwrap(), b"precious");
    // What cannot be replaced is said, and no reason to fail.
    fs::remove_file(&entry).unwrap();
    fs::create_dir_all(entry.join("full")).unwrap();
    let (mesh, was_read) = through(&cache, &path);
    assert!(was_read && mesh.findings.count(NOT_WRITTEN) == 1, "{:?}", mesh.findings);
    let only_owner = std::os::unix::fs::PermissionsExt::mode(
        &fs::metadata(folder.path().join("cache")).unwrap().permissions(),
    );
    assert!(only_owner & 0o700 == 0o700);
}

/// Notes are kept about files that were left alone, and believed as long as nothing shows a change.
#[test]
fn notes_know_a_file_by_its_times() {
    let folder = TempDir::new().unwrap();
    let note = folder.path().join("note");
    let settled = File::open(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).unwrap();
    let identity = Identity::of(&settled).unwrap();
    note::write(&note, &identity, &[3; 32]);
    assert_eq!(note::read(&note, &identity), Some([3; 32]));
    let mut new = tempfile::tempfile().unwrap();
    new.write_all(b"v").unwrap();
    let other = Identity::of(&new).unwrap();
    assert_eq!(note::read(&note, &other), None);
    note::write(&folder.path().join("new"), &other, &[3; 32]);
    assert!(!folder.path().join("new").exists(), "changed a moment ago");
    let whole = fs::read(&note).unwrap();
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 4;
        fs::write(&note, &damaged).unwrap();
        assert_eq!(note::read(&note, &identity), None, "byte {at}");
        fs::write(&note, &whole[..at]).unwrap();
        assert_eq!(note::read(&note, &identity), None, "cut at {at}");
    }
}

#[test]
fn a_cancelled_digest_ends_the_reading() {
    let folder = TempDir::new().unwrap();
    let cache = Cache::open(folder.path()).unwrap();
    let path = mesh_file(folder.path(), TEXT);
    let read = || -> Result<ObjFile> { panic!("it was cancelled") };
    let ended = cache.through((&path, &File::open(&path).unwrap()), &LIMITS, &|_| false, read);
    assert_eq!(ended.unwrap_err().message, crate::load::cancelled().message);
}

/// Who changes what the reader makes of a file has to count [`READER`] up, or old entries would be taken for new; and then
/// to write the new digest into `entry.digest`.
#[test]
fn a_reader_that_reads_otherwise_has_another_number() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("entry");
    entry::write(&path, &[0; 32], &parse(TEXT, Path::new("a.obj"))).unwrap();
    let digest = hex(blake3::hash(&fs::read(&path).unwrap()).as_bytes());
    let known = include_str!("entry.digest").trim();
    assert_eq!(format!("reader {READER}: {digest}"), known);
}
