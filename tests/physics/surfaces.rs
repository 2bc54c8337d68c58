//! The materials beyond the classics against exact answers: furnaces, slabs, and GGX's albedo by quadrature.

use crate::harness::{SKY, Stage, on_every_backend, sheet, sphere, square, stage};
use drt::accel::Backend;
use std::f64::consts::TAU;

/// A ball of the material `m` under a white sky.
fn ball(material: &str, spp: u32, backend: Backend, set: &[&str]) -> Stage {
    let toml = format!(
        "[camera]\nposition = [0, 0.2, 4]\nlook_at = [0, 0, 0]\nfov = 20\n[film]\nsize = [16, 16]\n\
         [render]\nspp = {spp}\nmax_depth = 1000\n[[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n{SKY}[materials.m]\n{material}\n"
    );
    stage(&toml, &[("m.obj", sphere(40, 60))], backend, set)
}

/// The albedo of a perfectly reflecting GGX surface with height-correlated shadowing, single scattering, by midpoints
/// over microfacet normals: ∫D·G2·(o·m)/cosθo dm with the normals placed by D·cosθm.
fn ggx_albedo(degrees: f64, alpha: f64) -> f64 {
    let (s, c) = degrees.to_radians().sin_cos();
    let lambda = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 - z * z) / (z * z)).sqrt() - 1.0);
    let n = 1000;
    let mut sum = 0.0;
    for i in 0..n {
        // u = 1 − v²: grazing normals count as 1/√(1 − u), which midpoints in u would not see.
        let v = (f64::from(i) + 0.5) / f64::from(n);
        let tan2 = alpha * alpha * (1.0 - v * v) / (v * v);
        let mz = 1.0 / (1.0 + tan2).sqrt();
        let mr = (1.0 - mz * mz).sqrt();
        for j in 0..n {
            let mx = mr * (TAU * (f64::from(j) + 0.5) / f64::from(n)).cos();
            let om = s * mx + c * mz;
            let iz = 2.0 * om * mz - c;
            if om > 0.0 && iz > 0.0 {
                sum += 2.0 * v * om / (c * mz) / (1.0 + lambda(c) + lambda(iz));
            }
        }
    }
    sum / f64::from(n * n)
}

#[test]
fn ggx_has_its_albedo_at_every_angle() {
    // Known in closed form where α is 1, seen from above.
    assert!((ggx_albedo(0.0, 1.0) - (1.0 - 2f64.ln())).abs() < 1e-6);
    on_every_backend(|backend| {
        for roughness in [0.3, 0.6, 1.0] {
            for degrees in [0.0, 45.0, 75.0, 85.0] {
                let rest = format!(
                    "{SKY}[materials.m]\ntype = \"conductor\"\nreflectance = 1.0\ncompensate = false\nroughness = {roughness}\n"
                );
                stage(&sheet(degrees, 256, 1, &rest), &[("sheet.obj", square(2.0, 0.0))], backend, &[])
                    .statistics()
                    .expect(
                        &format!("roughness {roughness} at {degrees}°"),
                        ggx_albedo(degrees, roughness * roughness),
                        5e-4,
                    );
            }
        }
    });
}

/// Fresnel's reflectance of glass with index 1.5 (O19's rows).
const FRESNEL: [(f64, f64); 6] = [
    (0.0, 0.04),
    (30.0, 0.041_523),
    (45.0, 0.050_240),
    (60.0, 0.089_187),
    (75.0, 0.253_061),
    (85.0, 0.612_800),
];

/// A pane shows (1−F)/(1+F) of what is behind it and reflects 2F/(1+F): light goes to and fro inside.
#[test]
fn panes_pass_what_slabs_do() {
    let wall = |emission: f64| {
        format!(
            "[[mesh]]\nfile = \"wall.obj\"\nmaterial = \"wall\"\n[materials.wall]\ntype = \"diffuse\"\nreflectance = 0.0\n\
             emission = {emission}\n[materials.m]\ntype = \"dielectric\"\nior = 1.5\nthin = true\n"
        )
    };
    on_every_backend(|backend| {
        for (degrees, f) in FRESNEL {
            let files = [("sheet.obj", square(2.0, 0.0)), ("wall.obj", square(50.0, -0.1))];
            for (rest, exact) in [(wall(1.0), (1.0 - f) / (1.0 + f)), (wall(0.0) + SKY, 2.0 * f / (1.0 + f))]
            {
                stage(&sheet(degrees, 256, 8, &rest), &files, backend, &[]).statistics().expect(
                    &format!("{degrees}°"),
                    exact,
                    1e-4,
                );
            }
        }
    });
}

/// A sheet that scatters to both sides shows the share of either.
#[test]
fn sheets_pass_their_share_of_diffuse_light() {
    let wall = "[[mesh]]\nfile = \"wall.obj\"\nmaterial = \"wall\"\n[materials.wall]\ntype = \"diffuse\"\nreflectance = 0.0\n";
    let sheet_of = "[materials.m]\ntype = \"translucent\"\nreflectance = 0.3\ntransmittance = 0.5\n";
    on_every_backend(|backend| {
        for (rest, exact) in [
            (format!("{SKY}{sheet_of}"), 0.8),
            // Before a black wall that hides the sky behind but for a margin.
            (format!("{SKY}{wall}{sheet_of}"), 0.3),
            (format!("{wall}emission = 1.0\n{sheet_of}"), 0.5),
        ] {
            let files = [("sheet.obj", square(2.0, 0.0)), ("wall.obj", square(500.0, -0.1))];
            stage(&sheet(20.0, 256, 1, &rest), &files, backend, &[]).statistics().expect(&rest, exact, 1e-5);
        }
    });
}

/// Tables keep every furnace at or below 1, and so err to the dark side; where they are coarsest by up to a hundredth.
#[test]
fn white_surfaces_vanish_or_are_a_little_dark() {
    on_every_backend(|backend| {
        for material in [
            "type = \"dielectric\"\nior = 1.5\nroughness = 0.7",
            "type = \"conductor\"\nreflectance = 1.0\nroughness = 0.6\nanisotropy = 0.8",
        ] {
            let found = ball(material, 64, backend, &[]).statistics();
            assert!(found.error < 1e-3, "{material}: {found:?} says nothing");
            let slack = 6.37 * found.error;
            assert!((0.99 - slack..=1.0 + slack).contains(&found.mean), "{material}: {found:?}");
        }
    });
}

/// What reflects or passes everything vanishes in a white furnace.
#[test]
fn white_surfaces_vanish() {
    on_every_backend(|backend| {
        for (material, model) in [
            ("type = \"dielectric\"\nior = 1.5\nroughness = 0.3", 5e-3),
            ("type = \"dielectric\"\nior = 1.5\nroughness = 0.6\nthin = true", 5e-3),
            ("type = \"plastic\"\nreflectance = 1.0", 1e-4),
            ("type = \"plastic\"\nreflectance = 1.0\nroughness = 0.5\nnonlinear = true", 3e-3),
            ("type = \"oren-nayar\"\nreflectance = 1.0\nroughness = 1.0", 1e-4),
            ("type = \"diffuse\"\nreflectance = 1.0\nroughness = 0.4", 1e-4),
            ("type = \"principled\"\nbase_color = 1.0", 3e-3),
            ("type = \"principled\"\nbase_color = 1.0\ntransmission = 1.0\nroughness = 0.4", 5e-3),
        ] {
            ball(material, 64, backend, &[]).statistics().expect(material, 1.0, model);
        }
    });
}

/// A black base shows the coat alone: E(0°) of a smooth one is F, and a coloured base adds T(o)·ρ·T̄/T̄.
#[test]
fn plastic_has_its_albedo() {
    on_every_backend(|backend| {
        for (degrees, f) in FRESNEL {
            for rho in [0.0, 0.5] {
                let rest =
                    format!("{SKY}[materials.m]\ntype = \"plastic\"\nior = 1.5\nreflectance = {rho}\n");
                // f = T(o)·T(i)·ρ/(π·T̄) integrates to T(o)·ρ.
                let exact = f + (1.0 - f) * rho;
                stage(&sheet(degrees, 256, 1, &rest), &[("sheet.obj", square(2.0, 0.0))], backend, &[])
                    .statistics()
                    .expect(&format!("ρ {rho} at {degrees}°"), exact, 1e-4);
            }
        }
    });
}

/// Smooth coats are deltas beside a diffuse base: every way to find lights, and every integrator, sees the same.
#[test]
fn deltas_beside_a_base_are_neither_lost_nor_counted_twice() {
    let plastic = "type = \"plastic\"\nreflectance = 0.5";
    let coated = "type = \"principled\"\nbase_color = 0.5\ncoat = 1.0\ncoat_roughness = 0.0";
    on_every_backend(|backend| {
        for material in [plastic, coated] {
            let seen = |set: &[&str]| ball(material, 64, backend, set).statistics();
            let expected = seen(&["render.max_depth=1"]).mean;
            for set in [
                ["render.lights=light", "render.integrator=path"],
                ["render.lights=bsdf", "render.integrator=path"],
                [
                    "render.lights=mis",
                    "render.integrator={ type = \"distribution\", rule = \"importance\", directions = 2 }",
                ],
                [
                    "render.lights=mis",
                    "render.integrator={ type = \"distribution\", rule = \"stratified\", directions = [[4, 4]] }",
                ],
            ] {
                seen(&["render.max_depth=1", set[0], set[1]]).expect(
                    &format!("{material}: {set:?}"),
                    expected,
                    3e-3,
                );
            }
        }
    });
}

/// A mixture shows the mean of its parts, whatever they are.
#[test]
fn mixtures_are_the_mean_of_their_parts() {
    let parts = "[materials.a]\ntype = \"diffuse\"\nreflectance = 0.2\n[materials.b]\ntype = \"mirror\"\nreflectance = 0.6\n\
                 [materials.c]\ntype = \"mix\"\nmaterials = [\"a\", \"b\"]\namount = 0.25\n";
    on_every_backend(|backend| {
        for (mix, exact) in [
            ("materials = [\"a\", \"b\"]\namount = 0.25", 0.3),
            // Half of the sheet is not there: what is behind shines through.
            ("materials = [\"a\", \"b\"]\nopacity = 0.5", 0.7),
            ("materials = [\"c\", \"b\"]", 0.45),
        ] {
            let rest = format!("{SKY}{parts}[materials.m]\ntype = \"mix\"\n{mix}\n");
            stage(&sheet(30.0, 256, 1, &rest), &[("sheet.obj", square(2.0, 0.0))], backend, &[])
                .statistics()
                .expect(mix, exact, 1e-4);
        }
    });
}

/// An MTL's PBR statements make a principled material, which a scene file's table changes key by key.
#[test]
fn physical_statements_of_an_mtl_make_principled_materials() {
    let mesh = format!("mtllib m.mtl\nusemtl m\n{}", square(2.0, 0.0));
    let mtl = "newmtl m\nKd 0.5 0.5 0.5\nKs 0 0 0\nPr 0.6\nPm 0\n".to_string();
    on_every_backend(|backend| {
        for (patch, exact) in [("", 0.5), ("[materials.m]\nbase_color = 0.25\n", 0.25)] {
            let toml = sheet(0.0, 64, 1, &format!("{SKY}{patch}")).replace("material = \"m\"\n", "");
            let files = [("sheet.obj", mesh.clone()), ("m.mtl", mtl.clone())];
            // The coat's tables err to the dark side: by 5e-4 of it here, with any number of paths.
            stage(&toml, &files, backend, &[]).statistics().expect(patch, exact, 6e-4);
        }
    });
}
