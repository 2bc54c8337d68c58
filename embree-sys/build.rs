//! Finds Debian's Embree (4.x or 3.13), generates its bindings and compiles the shim.
//!
//! Published to dependents (`links = "embree"`): `DEP_EMBREE_VERSION`, e.g. `3.13.5`.

use std::path::{Path, PathBuf};
use std::process::{Command, exit};

/// The versions that can be bound: header directory (also the library's name without `lib`), major version.
const KNOWN: [(&str, u32); 2] = [("embree4", 4), ("embree3", 3)];

const ADVICE: &str = "run `sudo apt-get install libembree-dev libclang-dev` (or ./setup.sh), \
                      or build without Embree: `cargo build --no-default-features`";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=shim.c");
    println!("cargo::rerun-if-env-changed=EMBREE_DIR");
    println!("cargo::rerun-if-env-changed=LIBCLANG_PATH");

    let prefix = std::env::var_os("EMBREE_DIR").map(PathBuf::from);
    let Some(embree) = Embree::find(prefix.as_deref()) else {
        fail("Embree's headers were not found");
    };
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    embree.bind(&out.join("bindings.rs"));
    embree.compile_shim();
    embree.link();
}

/// One sentence instead of a panic's backtrace.
fn fail(what: &str) -> ! {
    println!("cargo::error={what}; {ADVICE}");
    exit(1)
}

/// An Embree that was found.
struct Embree {
    /// `embree3` or `embree4`.
    name: &'static str,
    major: u32,
    /// The directory that holds `name/`.
    include: PathBuf,
    /// Where the library is, when not on the linker's own path.
    library: Option<PathBuf>,
}

impl Embree {
    /// Looks in `prefix` (EMBREE_DIR), else in the system's directories; the newest version wins.
    fn find(prefix: Option<&Path>) -> Option<Embree> {
        let prefixes: Vec<PathBuf> = match prefix {
            Some(prefix) => vec![prefix.to_path_buf()],
            None => vec!["/usr".into(), "/usr/local".into()],
        };
        for (name, major) in KNOWN {
            for prefix in &prefixes {
                let include = prefix.join("include");
                if include.join(name).join("rtcore.h").is_file() {
                    let library =
                        (prefix != Path::new("/usr")).then(|| library_directory(prefix, name)).flatten();
                    return Some(Embree { name, major, include, library });
                }
            }
        }
        None
    }

    fn header(&self, file: &str) -> PathBuf {
        self.include.join(self.name).join(file)
    }

    /// The version in `rtcore_config.h`.
    fn version(&self) -> String {
        let file = self.header("rtcore_config.h");
        println!("cargo::rerun-if-changed={}", file.display());
        let text = std::fs::read_to_string(&file)
            .unwrap_or_else(|e| fail(&format!("cannot read {}: {e}", file.display())));
        match text.lines().find_map(|line| line.strip_prefix("#define RTC_VERSION_STRING ")) {
            Some(version) => version.trim().trim_matches('"').to_string(),
            None => fail(&format!("{} has no RTC_VERSION_STRING", file.display())),
        }
    }

    fn bind(&self, to: &Path) {
        // bindgen panics where libclang cannot be loaded, and its message would come with a backtrace.
        std::panic::set_hook(Box::new(|_| {}));
        let generated = std::panic::catch_unwind(|| {
            bindgen::Builder::default()
                .header(self.header("rtcore.h").to_string_lossy())
                .clang_arg(format!("-I{}", self.include.display()))
                .allowlist_function("rtc.*")
                .allowlist_type("RTC.*")
                .allowlist_var("RTC_.*")
                // A C enum may hold any integer: a Rust enum in a callback's signature would be undefined behaviour.
                .default_enum_style(bindgen::EnumVariation::Consts)
                .prepend_enum_name(false)
                .rust_edition(bindgen::RustEdition::Edition2024)
                .rust_target(bindgen::RustTarget::stable(85, 0).unwrap_or_default())
                .derive_default(true)
                .use_core()
                .layout_tests(false)
                .generate_comments(false)
                .generate()
        });
        let _ = std::panic::take_hook();
        match generated {
            Ok(Ok(bindings)) => {
                if let Err(e) = bindings.write_to_file(to) {
                    fail(&format!("cannot write {}: {e}", to.display()));
                }
            }
            Ok(Err(e)) => fail(&format!("Embree's headers could not be read ({})", one_line(&e.to_string()))),
            Err(_) => fail("libclang, which reads Embree's headers, was not found"),
        }
    }

    fn compile_shim(&self) {
        let compiled = cc::Build::new()
            .file("shim.c")
            .include(&self.include)
            .define("DRT_EMBREE_MAJOR", self.major.to_string().as_str())
            .cargo_warnings(false)
            .try_compile("drt_embree_shim");
        if let Err(e) = compiled {
            let compiler = Command::new("cc").arg("--version").output().is_ok();
            let why =
                if compiler { one_line(&e.to_string()) } else { "no C compiler (build-essential)".into() };
            fail(&format!("the shim over Embree's headers could not be compiled: {why}"));
        }
    }

    fn link(&self) {
        if let Some(library) = &self.library {
            println!("cargo::rustc-link-search=native={}", library.display());
        }
        println!("cargo::rustc-link-lib=dylib={}", self.name);
        println!("cargo::metadata=version={}", self.version());
    }
}

/// Where `libNAME.so` is under `prefix`.
fn library_directory(prefix: &Path, name: &str) -> Option<PathBuf> {
    let arch = std::env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let places = [format!("lib/{arch}-linux-gnu"), "lib64".into(), "lib".into()];
    places.iter().map(|p| prefix.join(p)).find(|d| d.join(format!("lib{name}.so")).exists())
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
