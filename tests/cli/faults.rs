//! The fault harness: the same small run again and again, with another thing going wrong each time. Each run keeps the
//! universal invariant (`universal.rs`), and the output holds its old bytes or a whole picture.
//!
//! `DRT_HEAVY_TESTS=1` walks every k-th system call of every kind, and many limits of memory; otherwise a few of each
//! are tried. Kills are in `resume.rs`. What a machine does not permit (tracing, mounting) says `SKIPPED`.

use super::universal::{Run, engines, installed, tiny};
use super::{folder, names};
use std::fs;
use std::path::Path;
use std::process::Command;

fn heavy() -> bool {
    std::env::var_os("DRT_HEAVY_TESTS").is_some_and(|v| v == "1")
}

/// A run that writes two outputs over old ones.
const WORDS: [&str; 7] = ["s.toml", "-q", "-o", "x.exr", "-o", "y.png", "--stats"];

fn words<'w>(engine: &[&'w str]) -> Vec<&'w str> {
    tiny(&[&WORDS[..], &["z.json"]].concat(), engine)
}

/// Old outputs that are whole, and differ from what a run would write.
fn old_outputs(dir: &Path) {
    Run::new(dir, &["s.toml", "--size", "3x3", "--spp", "1", "-q", "-o", "x.exr", "-o", "y.png"])
        .check()
        .expect(0, &[]);
    fs::write(dir.join("z.json"), "{}").unwrap();
}

/// True where `strace` may trace here, into `log`; says so where not.
fn may_trace(log: &Path) -> bool {
    if !installed("strace") {
        return false;
    }
    let traced = Command::new("strace").args(["-f", "-o"]).arg(log).arg("true").output().unwrap();
    if !traced.status.success() {
        eprintln!("SKIPPED a part of this test: strace may not trace here");
    }
    traced.status.success()
}

/// A folder with a scene, another one, and the log of `strace` in that; none where it may not trace.
fn traced_folders() -> Option<(tempfile::TempDir, tempfile::TempDir, std::path::PathBuf)> {
    let beside = tempfile::TempDir::new().unwrap();
    let log = beside.path().join("log");
    may_trace(&log).then(|| (folder(), beside, log))
}

/// D2: whichever call fails, for whichever reason, at whichever time.
#[test]
fn d2_every_failing_call() {
    let Some((folder, _beside, log)) = traced_folders() else { return };
    let dir = folder.path();
    let inputs = format!("-P {0}/s.toml -P {0}/t.obj", dir.display());
    let rows: [(&str, &str, &[&str]); 11] = [
        // Of the inputs only: the dynamic linker's reads come first, and what it does then is not ours.
        ("openat", &inputs, &["EIO", "EMFILE", "EACCES"]),
        ("read", &inputs, &["EIO", "EINTR"]),
        ("statx", &inputs, &["EIO"]),
        ("close", &inputs, &["EIO"]),
        // Of everything: only the program does these.
        ("write", "", &["ENOSPC", "EIO", "EINTR"]),
        ("fsync", "", &["EIO", "ENOSPC"]),
        ("/^rename", "", &["ENOSPC", "EACCES"]),
        ("/^link", "", &["ENOSPC"]),
        ("fchmod", "", &["EIO"]),
        ("ftruncate", "", &["EIO"]),
        ("clone3", "", &["EAGAIN"]),
    ];
    let mut injected = 0;
    for (call, only, errors) in rows {
        for error in errors {
            let most = if heavy() { 1000 } else { 2 };
            injected += (1..=most).take_while(|k| inject(dir, &log, call, only, error, *k)).count();
        }
    }
    eprintln!("{injected} calls failed");
    assert!(injected > 20, "only {injected} calls failed");
}

/// Lets each thread's `k`-th `call` fail; `false` where there is none.
fn inject(dir: &Path, log: &Path, call: &str, only: &str, error: &str, k: usize) -> bool {
    old_outputs(dir);
    let trace = format!("{only} -e 'trace={call}' -e 'inject={call}:error={error}:when={k}'");
    let script = format!("exec strace -f -qq -o {} {trace} \"$0\" \"$@\"", log.display());
    let run = Run::new(dir, &words(&["--backend", "bvh", "--threads", "2"])).limits(&script);
    // The words about a write that failed are written as well, and another thread's k-th write may be that.
    let ended = if call == "write" { run.maybe_mute().check() } else { run.check() };
    let log = String::from_utf8_lossy(&fs::read(log).unwrap()).into_owned();
    let what = format!("{call} {error} {k}: {:?} {}", ended.code, ended.err);
    assert!(matches!(ended.code, Some(0 | 1)), "{what}");
    log.contains("(INJECTED)")
}

/// D5: killed as it enters whichever call with which outputs are written, each is old or whole, and the next run leaves
/// no temporary file.
#[test]
fn d5_killed_at_every_call_that_writes() {
    let Some((folder, _beside, log)) = traced_folders() else { return };
    let dir = folder.path();
    let words = words(&["--backend", "bvh", "--threads", "1"]);
    let mut kills = 0;
    for call in ["write", "fsync", "ftruncate", "fchmod", "/^rename", "/^link", "/^unlink", "close"] {
        for k in 1..=if heavy() { 1000 } else { 3 } {
            old_outputs(dir);
            let mut command = Command::new("strace");
            command.args(["-f", "-qq", "-o"]).arg(&log).args(["-e", &format!("trace={call}")]);
            command.args(["-e", &format!("inject={call}:signal=SIGKILL:when={k}")]);
            let program = assert_cmd::cargo::cargo_bin("drt");
            let status = command.arg(program).args(&words).current_dir(dir).status().unwrap();
            if status.success() {
                break;
            }
            kills += 1;
            for picture in ["x.exr", "y.png"] {
                let read = drt::load::picture::read(&dir.join(picture));
                assert!(read.is_ok(), "{call} {k}: {picture}: {:?}", read.err());
            }
            let stats = fs::read(dir.join("z.json")).unwrap();
            assert!(serde_json::from_slice::<serde_json::Value>(&stats).is_ok(), "{call} {k}: {stats:?}");
            super::drt(dir, &words).expect(0, &[]);
            let left = names(dir).into_iter().find(|name| name.starts_with(".drt-"));
            assert_eq!(left, None, "{call} {k}: left after the next run");
        }
    }
    eprintln!("{kills} kills");
    assert!(kills > 10, "only {kills} kills");
}

/// D7: under any limit of the address space from 256 MB up it ends with 0 or 1, and says why.
#[test]
fn d7_any_limit_of_memory() {
    let folder = folder();
    let dir = folder.path();
    // Below that the system cannot even start it.
    let starts = |limit: &u64| {
        let script = format!("ulimit -v {limit}; exec \"$0\" --version");
        let program = assert_cmd::cargo::cargo_bin("drt");
        Command::new("sh").args(["-c", &script]).arg(program).output().unwrap().status.success()
    };
    let least = (250_000..).step_by(10_000).find(starts).unwrap();
    let limits: Vec<u64> = if heavy() {
        (0..60).map(|i| least + 10_000 * i).collect()
    } else {
        [0, 40_000, 150_000, 400_000].map(|more| least + more).to_vec()
    };
    for engine in engines() {
        for limit in &limits {
            old_outputs(dir);
            let ended = Run::new(dir, &words(&engine)).limits(&format!("ulimit -v {limit}")).check();
            assert!(matches!(ended.code, Some(0 | 1)), "{limit} KiB: {:?} {}", ended.code, ended.err);
        }
    }
}

/// D2: a disk that is full, and one that becomes full.
#[test]
fn d2_a_full_disk() {
    let folder = folder();
    let dir = folder.path();
    let mount = "unshare -m sh -c 'mount -t tmpfs -o size=$1k tmpfs full && shift && exec \"$@\"' sh";
    fs::create_dir(dir.join("full")).unwrap();
    let try_it =
        Command::new("sh").args(["-c", &format!("{mount} 64 true")]).current_dir(dir).output().unwrap();
    if !try_it.status.success() {
        eprintln!("SKIPPED: no file system may be mounted here");
        return;
    }
    let program = assert_cmd::cargo::cargo_bin("drt");
    let (mut failed, mut written) = (0, 0);
    let step = if heavy() { 4 } else { 40 };
    for size in (8..200).step_by(step) {
        // In the new file system: an old output, a run over it, and what is there afterwards.
        let script = "echo old > full/x.exr; \"$0\" t.obj --ground --size 96x64 --spp 1 -q -o full/x.exr; \
                      echo \"code $?\"; ls -A full; od -An -c -N4 full/x.exr";
        let mut command = Command::new("sh");
        command.args(["-c", &format!("{mount} {size} sh -c '{script}' \"$0\"")]).arg(&program);
        let output = command.current_dir(dir).output().unwrap();
        let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let lines: Vec<&str> = out.lines().collect();
        let [code, "x.exr", bytes] = lines[..] else { panic!("{size} KiB: {out} {err}") };
        match code {
            "code 0" => written += 1,
            "code 1" => {
                failed += 1;
                assert!(bytes.contains("o   l   d"), "{size} KiB: {out}");
                assert!(err.starts_with("error: full/x.exr: ") && err.contains("No space left"), "{err}");
            }
            _ => panic!("{size} KiB: {out} {err}"),
        }
    }
    assert!(failed > 0 && written > 0, "{failed} failed, {written} did not");
}

/// D10: what surrounds a run does not change its bytes.
#[test]
fn d10_surroundings_do_not_matter() {
    let folder = folder();
    let dir = folder.path();
    let outside = tempfile::TempDir::new().unwrap();
    let mut all: Vec<Vec<u8>> = Vec::new();
    for (i, surroundings) in [
        "true",
        "export LANG=de_DE.UTF-8 LC_ALL=de_DE.UTF-8",
        "export LANG=C LC_ALL=C",
        "export TZ=Pacific/Kiritimati",
        "unset HOME PATH USER",
        "export HOME=/nonexistent TMPDIR=/nonexistent",
        "exec <&-",
        "exec >&-",
        "exec <&- >&-",
        "umask 777",
        "ulimit -n 64",
        "trap '' PIPE HUP",
        "cd / && cd \"$OLDPWD\"",
    ]
    .into_iter()
    .enumerate()
    {
        let name = outside.path().join(format!("{i}.exr"));
        let name = name.to_string_lossy();
        Run::new(dir, &["s.toml", "-q", "--threads", "2", "-o", &name])
            .limits(surroundings)
            .check()
            .expect(0, &[]);
        all.push(read_whatever_its_mode(Path::new(&*name)));
    }
    // A closed standard error leaves nothing to say an error on, and a folder that may not be written is no matter.
    let name = outside.path().join("last.exr");
    let script =
        "chmod a-w . ; \"$0\" s.toml -q --threads 2 -o \"$1\" 2>&- ; code=$?; chmod u+w . ; exit $code";
    let mut command = Command::new("sh");
    command.args(["-c", script]).arg(assert_cmd::cargo::cargo_bin("drt")).arg(&name);
    assert_eq!(command.current_dir(dir).status().unwrap().code(), Some(0));
    all.push(fs::read(&name).unwrap());
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "the bytes differ");
    assert_eq!(names(dir), ["s.toml", "t.obj"]);
}

/// Under `umask 777` nobody may read what was written.
fn read_whatever_its_mode(path: &Path) -> Vec<u8> {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(0o600)).unwrap();
    fs::read(path).unwrap()
}

/// D9: of two runs on one output the last one wins, and they never mix.
#[test]
fn d9_two_runs_on_one_output() {
    let folder = folder();
    let dir = folder.path();
    let words = |seed: &'static str| tiny(&["s.toml", "-q", "-o", "x.exr", "--seed", seed], &[]);
    let alone = ["1", "2"].map(|seed| {
        Run::new(dir, &words(seed)).check().expect(0, &[]);
        fs::read(dir.join("x.exr")).unwrap()
    });
    assert_ne!(alone[0], alone[1]);
    let program = assert_cmd::cargo::cargo_bin("drt");
    for _ in 0..if heavy() { 20 } else { 5 } {
        let pair =
            ["1", "2"].map(|seed| Command::new(&program).args(words(seed)).current_dir(dir).spawn().unwrap());
        for mut child in pair {
            assert_eq!(child.wait().unwrap().code(), Some(0));
        }
        assert!(alone.contains(&fs::read(dir.join("x.exr")).unwrap()), "the two runs mixed");
        assert_eq!(names(dir), ["s.toml", "t.obj", "x.exr"]);
    }
}
