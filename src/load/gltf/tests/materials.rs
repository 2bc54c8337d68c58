//! What a glTF document says of surfaces.

use super::*;

fn material(material: Value) -> Object {
    let mut document = square();
    document["materials"] = json!([material]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
    document["images"] = json!([{ "uri": "data:image/png;base64,iVBORw0KGgo=" }]);
    document["samplers"] = json!([{ "wrapS": 33071, "magFilter": 9728 }]);
    document["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    read(&document).unwrap()
}

#[test]
fn materials_become_principled_ones() {
    let object = material(json!({
        "name": "paint",
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 0.5], "metallicFactor": 0.75, "roughnessFactor": 0.25 },
        "emissiveFactor": [1, 0.5, 0],
        "alphaMode": "BLEND",
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
            "KHR_materials_ior": { "ior": 1.25 },
            "KHR_materials_transmission": { "transmissionFactor": 0.5 },
            "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.125 },
            "KHR_materials_sheen": { "sheenColorFactor": [0.25, 0.5, 0], "sheenRoughnessFactor": 0.75 },
            "KHR_materials_specular": { "specularFactor": 0.5 },
        },
    }));
    let spec = &object.materials[0];
    let Bsdf::Principled(principled) = &spec.model else { panic!("principled") };
    let look = principled.look();
    assert_eq!((spec.name.as_str(), spec.opacity, spec.emission), ("paint", 0.5, Rgb::new(4.0, 2.0, 0.0)));
    assert_eq!((look.base_color, look.metallic, look.roughness), (Rgb::new(0.5, 0.25, 1.0), 0.75, 0.25));
    assert_eq!((look.ior, look.transmission, look.coat, look.coat_roughness), (1.25, 0.5, 1.0, 0.125));
    assert_eq!((look.sheen, look.sheen_roughness, look.specular), (0.5, 0.75, 0.25));
    let plain = material(json!({}));
    let Bsdf::Principled(principled) = &plain.materials[0].model else { panic!("principled") };
    assert_eq!(
        (principled.look().metallic, principled.look().roughness),
        (1.0, 1.0),
        "the format's defaults"
    );
    assert_eq!(plain.materials[0].name, "material 0");
    assert_eq!(read(&square()).unwrap().materials[0].model.name(), "diffuse", "no material is clay");
}

#[test]
fn textures_keep_their_channels_and_places() {
    let transform = json!({ "KHR_texture_transform": { "offset": [0.25, 0.5], "scale": [2, 4] } });
    let object = material(json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 1, 1, 1],
            "baseColorTexture": { "index": 0, "extensions": transform },
            "metallicRoughnessTexture": { "index": 0 },
            "roughnessFactor": 0.5,
        },
        "normalTexture": { "index": 0, "scale": 2 },
        "emissiveTexture": { "index": 0, "texCoord": 1 },
        "emissiveFactor": [1, 1, 1],
        "alphaMode": "MASK",
        "alphaCutoff": 0.25,
    }));
    let maps = &object.materials[0].maps;
    let map = |slot: Slot| &maps.iter().find(|map| map.slot == slot).expect("a map").mapping;
    let base = map(Slot::Parameter(Parameter::BaseColor));
    assert_eq!((base.gain, base.transfer, base.wrap), (Rgb::new(0.5, 1.0, 1.0), Transfer::Srgb, Wrap::Clamp));
    // v = 0.5 + 4 (1 − w), so w' = 1 − v = 4 w − 3.5.
    assert_eq!((base.scale, base.offset), ([2.0, 4.0], [0.25, -3.5]));
    let roughness = map(Slot::Parameter(Parameter::Roughness));
    assert_eq!((roughness.channel, roughness.gain.x), (Some(Channel::Green), 0.5));
    assert_eq!(map(Slot::Parameter(Parameter::Metallic)).channel, Some(Channel::Blue));
    assert_eq!(map(Slot::Normal(2.0)).transfer, Transfer::Linear);
    let alpha = map(Slot::Alpha);
    let at = |alpha_value: f32| alpha.gain.x * alpha_value + alpha.base.x;
    assert!(at(0.2499) <= 0.0 && at(0.25) >= 1.0, "a step at the cutoff");
    assert_eq!(object.findings.count("texture-not-shown"), 1, "the other coordinates");
}

#[test]
fn a_rotation_that_all_textures_share_turns_the_coordinates() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let info = json!({ "index": 0, "extensions": { "KHR_texture_transform": { "rotation": quarter } } });
    let object = material(json!({ "pbrMetallicRoughness": { "baseColorTexture": info } }));
    // Vertex 1 has (1, 1) in the file; turned it is (1, −1), which is (1, 2) with v up.
    let uv = object.mesh.uvs.as_ref().unwrap().values[1];
    assert!((uv[0] - 1.0).abs() < 1e-6 && (uv[1] - 2.0).abs() < 1e-6, "{uv:?}");
    assert_eq!(object.findings.count("texture-rotation-ignored"), 0);
}
