//! Judges: values written by hand, and the formulas that the modules state.

use super::*;

fn bytes(width: u32, channels: usize, data: &[u8]) -> Arc<Texels> {
    let height = data.len() / width as usize / channels;
    Arc::new(Texels::new(width, height as u32, channels, Data::U8(data.to_vec())).unwrap())
}

fn nearest(transfer: Transfer) -> Mapping {
    Mapping { filter: Filter::Nearest, ..Mapping::plain(transfer) }
}

#[test]
fn channels_and_codes() {
    let texels = bytes(2, 4, &[255, 0, 51, 102, 0, 255, 0, 255]);
    assert!(texels.has_alpha());
    let at = |channel| {
        let mapping = Mapping { channel, ..nearest(Transfer::Linear) };
        Texture::new(texels.clone(), mapping).number(Vec2::new(0.25, 0.5))
    };
    assert_eq!(at(None), 1.0);
    assert_eq!(at(Some(Channel::Green)), 0.0);
    assert!((at(Some(Channel::Blue)) - 0.2).abs() < 1e-7);
    assert!((at(Some(Channel::Alpha)) - 0.4).abs() < 1e-7);
    assert!((at(Some(Channel::Luminance)) - (0.2126 + 0.0722 * 0.2)).abs() < 1e-6);
    // Alpha is never sRGB.
    let mapping = Mapping { channel: Some(Channel::Alpha), ..nearest(Transfer::Srgb) };
    assert!((Texture::new(texels, mapping).number(Vec2::new(0.25, 0.5)) - 0.4).abs() < 1e-7);
    let deep = Texels::new(1, 1, 1, Data::U16(vec![128 * 257])).unwrap();
    let value = Texture::new(Arc::new(deep), Mapping::plain(Transfer::Srgb)).rgb(Vec2::ZERO);
    assert!((value - 0.215861).abs().max_element() < 1e-6);
}

#[test]
fn alpha_that_is_the_same_everywhere_says_nothing() {
    for alpha in [0, 77, 255] {
        assert!(!bytes(2, 2, &[1, alpha, 2, alpha]).has_alpha());
    }
    assert!(!bytes(2, 3, &[1, 2, 3, 4, 5, 6]).has_alpha());
    assert!(bytes(2, 2, &[1, 254, 2, 255]).has_alpha());
}

#[test]
fn what_does_not_fit_is_refused() {
    for (width, height, channels, len) in
        [(0, 1, 1, 0), (1, 0, 1, 0), (2, 2, 3, 11), (1, 1, 5, 5), (1, 1, 0, 0), (u32::MAX, u32::MAX, 4, 4)]
    {
        assert!(Texels::new(width, height, channels, Data::U8(vec![0; len])).is_err());
    }
}

/// Any texture coordinate gives a finite value of the picture: no index is out of range, and nothing is NaN.
#[test]
fn any_coordinate_is_somewhere() {
    let strange = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        1e-30,
        -1e-30,
        -1e-8,
        0.999_999_94,
        1e9,
        -1e9,
        1e30,
        -1e30,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    for (width, count) in [(1, 1), (2, 4), (3, 9), (7, 7)] {
        let texels = bytes(width, 1, &vec![255; count]);
        for row in Wrap::TABLE {
            for filter in Filter::TABLE {
                let mapping = Mapping { wrap: row.2, filter: filter.2, ..Mapping::plain(Transfer::Linear) };
                let texture = Texture::new(texels.clone(), mapping);
                let set =
                    Texture::tiles(Tiles::new(vec![(1001, texels.clone())]).unwrap(), mapping, Rgb::ONE);
                for u in strange {
                    for v in strange {
                        let uv = Vec2::new(u, v);
                        assert_eq!(texture.rgb(uv), Rgb::ONE, "{uv} {} {}", row.0, filter.0);
                        assert_eq!(set.rgb(uv), Rgb::ONE, "{uv} {} {}", row.0, filter.0);
                    }
                }
            }
        }
    }
}

#[test]
fn floats_that_are_none_become_zero() {
    let values = vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -2.0, 0.5, 1e30];
    let texels = Texels::new(2, 1, 3, Data::F32(values)).unwrap();
    let all: Vec<[f32; 4]> = texels.pixels(Transfer::Linear).collect();
    assert_eq!(all, [[0.0, 0.0, 0.0, 1.0], [-2.0, 0.5, 1e30, 1.0]]);
}

#[test]
fn means_count_every_texel_and_tile() {
    let mapping = Mapping { gain: Rgb::splat(2.0), base: Rgb::ONE, ..Mapping::plain(Transfer::Linear) };
    let a = bytes(2, 1, &[0, 255]);
    assert_eq!(Texture::new(a.clone(), mapping).mean(), Rgb::splat(2.0));
    let set = Texture::tiles(
        Tiles::new(vec![(1002, bytes(2, 1, &[255, 255])), (1001, a)]).unwrap(),
        mapping,
        Rgb::ZERO,
    );
    assert_eq!(set.mean(), Rgb::splat(2.5));
}

/// A turned normal is unit and on the side of `ng`, whatever the picture says and however the triangle lies.
#[test]
fn reliefs_stay_outside() {
    let wild = bytes(4, 3, &(0..48u32).map(|i| (i * 97 % 256) as u8).collect::<Vec<u8>>());
    let mesh = crate::shape::Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.3]], vec![[0, 1, 2]]);
    let [a, b, c] = mesh.triangle(0);
    let ng = crate::shape::geometric_normal(a, b, c);
    let corners = [
        [Vec2::ZERO, Vec2::X, Vec2::Y],
        [Vec2::ZERO, Vec2::Y, Vec2::X],
        [Vec2::ZERO, Vec2::splat(1e-20), Vec2::Y],
        [Vec2::ZERO, Vec2::X, Vec2::X * 2.0],
        [Vec2::splat(f32::NAN); 3],
    ];
    for shape in [
        Shape::Normal(1.0),
        Shape::Normal(-50.0),
        Shape::Height(0.5),
        Shape::Height(1e9),
        Shape::Height(-1e30),
    ] {
        let relief = Relief { map: Texture::new(wild.clone(), Mapping::plain(Transfer::Linear)), shape };
        for uvs in corners {
            let Some(tangents) = Tangents::new(&mesh, 0, uvs) else { continue };
            for i in 0..100 {
                let uv = Vec2::new(i as f32 * 0.37, i as f32 * 0.11);
                let n = relief.normal(ng, ng, &tangents, uv);
                assert!((n.length() - 1.0).abs() < 1e-4 && n.dot(ng) > 5e-4, "{shape:?} {uvs:?} {uv}: {n}");
            }
        }
    }
    assert!(Tangents::new(&mesh, 0, corners[3]).is_none() && Tangents::new(&mesh, 0, corners[4]).is_none());
}
