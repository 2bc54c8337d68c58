//! Thin lenses, panoramas, and the focus on what a pixel sees.

use crate::harness::{obj, on_every_backend, stage};
use drt::accel::Backend;
use drt::film::Image;
use drt::render;

/// A lamp of radius .05 at distance 10 seen by a lens of radius .2 focused at 6; 16 × 16 pixels of .5 × .5 metres at 6.
fn lens(rest: &str) -> String {
    format!(
        "[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, -1]\nfov = 4.771888\naperture = 0.2\nfocus_distance = 6\n{rest}\n\
         [film]\nsize = [16, 16]\n[render]\nspp = 16384\nmax_depth = 0\n[[light]]\ntype = \"sphere\"\ncenter = [0, 0, -10]\n\
         radius = 0.05\nradiance = 1000\n"
    )
}

/// Second moments of the green channel in metres of the plane in focus.
fn moments(image: &Image) -> [f64; 2] {
    let green = image.f32_channel("G").unwrap();
    let mut sums = [0.0; 3];
    for (i, value) in green.iter().enumerate() {
        let at = |i: usize| (i as f64 - 7.5) / 32.0;
        let (x, y, w) = (at(i % 16), at(i / 16), f64::from(*value));
        for (sum, term) in sums.iter_mut().zip([w, w * x * x, w * y * y]) {
            *sum += term;
        }
    }
    [sums[1] / sums[0], sums[2] / sums[0]]
}

/// A point at distance d is a disc of radius A·|d − f|/d in the plane in focus: E[x²] = R²/4; a square one of four blades
/// with its corners at R: R²/6. The pixel adds its own 1/12, the lamp a quarter of its radius squared, as seen in the plane.
#[test]
fn what_is_out_of_focus_is_a_disc_of_the_right_size() {
    let r = 0.2f64 * 4.0 / 10.0;
    let own = (1.0f64 / 32.0).powi(2) / 12.0 + (0.05f64 * 0.6).powi(2) / 4.0;
    let measure = |rest: &str| moments(&stage(&lens(rest), &[], Backend::ALL[0], &[]).render(|_| ()).0);
    for (rest, exact) in
        [("", r * r / 4.0), ("blades = 4", r * r / 6.0), ("blades = 4\nblade_rotation = 20", r * r / 6.0)]
    {
        for m in measure(rest) {
            assert!((m / (exact + own) - 1.0).abs() < 0.03, "{rest}: {m} is not {}", exact + own);
        }
    }
    // Three blades, one corner up: the picture of a point behind the focus is not turned over sideways, and its centroid
    // stays; its height differs from its width by nothing either.
    let [x, y] = measure("blades = 3\nblade_rotation = 90");
    let triangle = r * r / 8.0 + own;
    assert!((x / triangle - 1.0).abs() < 0.03 && (y / triangle - 1.0).abs() < 0.03, "{x} {y} {triangle}");
}

/// A panorama that looks along +z shows an environment as its map: a gradient has its own value in every pixel.
#[test]
fn a_panorama_is_a_map_of_all_directions() {
    on_every_backend(|backend| {
        let toml = "[camera]\ntype = \"panorama\"\nposition = [1, 2, 3]\nlook_at = [1, 2, 9]\n[film]\nsize = [64, 32]\n\
                    [render]\nspp = 16\n[[light]]\ntype = \"environment\"\nsky = \"overcast\"\n\
                    [[light]]\ntype = \"sphere\"\ncenter = [4, 2, 3]\nradius = 0.5\nradiance = 7\n";
        let image = stage(toml, &[], backend, &[]).render(|_| ()).0;
        let green = image.f32_channel("G").unwrap();
        // The sphere stands at +x: u = ¼, half of the height.
        assert!((green[16 * 64 + 16] - 7.0).abs() < 1e-6 && green[16 * 64 + 48] < 1.0);
        // 1.2 at the zenith, .4 and less at the horizon, .2 at the nadir.
        assert!((green[10] - 1.2).abs() < 0.01 && (green[31 * 64 + 10] - 0.2).abs() < 0.01);
    });
}

#[test]
fn focus_is_the_depth_of_what_a_pixel_sees() {
    on_every_backend(|backend| {
        let wall = obj(&[vec![[-9.0, -9.0, -5.0], [9.0, -9.0, -5.0], [9.0, 9.0, -5.0], [-9.0, 9.0, -5.0]]]);
        let toml =
            format!("{}[[mesh]]\nfile = \"wall.obj\"\n", lens("").replace("[0, 0, -10]", "[0.05, 0, -3]"));
        let stage = stage(&toml, &[("wall.obj", wall)], backend, &["film.size=[65,65]"]);
        let focus = |pixel| render::focus(&stage.scene, &stage.settings, stage.accel(), pixel);
        // Along the axis, not along the ray: the same depth in the corner.
        assert!((focus([2, 3]).unwrap() - 5.0).abs() < 1e-5 && (focus([10, 32]).unwrap() - 5.0).abs() < 1e-5);
        // The lamp at x = .05 and depth 3, less its radius: 32.5 + .05/3·(6·130) = 45.5.
        assert!((focus([45, 32]).unwrap() - 2.95).abs() < 1e-3, "{:?}", focus([45, 32]));
        assert!(focus([65, 0]).unwrap_err().to_string().contains("outside the picture"));
    });
}
