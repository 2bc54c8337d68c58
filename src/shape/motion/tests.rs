use super::*;

fn turned(degrees: f64) -> Pose {
    Pose::new(DVec3::ONE, Some((DVec3::Z, degrees)), DVec3::ZERO)
}

#[test]
fn rotations_follow_the_right_hand_and_quarter_turns_are_exact() {
    assert_eq!(rotation(DVec3::Y, 90.0) * DVec3::Z, DVec3::X);
    assert_eq!(rotation(DVec3::X, -90.0) * DVec3::Y, -DVec3::Z);
    assert_eq!(rotation(DVec3::X, -90.0) * DVec3::Z, DVec3::Y);
    let eighth = rotation(DVec3::Z, 45.0) * DVec3::X;
    assert!((eighth - DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)).length() < 1e-15);
}

/// Every point stays on its circle, at an angle in proportion to the time, through more than a turn.
#[test]
fn a_wheel_turns_on_circles_at_an_even_speed() {
    let motion = Motion::new(&[(1.0, turned(-30.0)), (3.0, turned(690.0))]).unwrap();
    for i in 0..=20 {
        let time = 1.0 + 0.1 * f64::from(i);
        let p = motion.at(time).transform_point3(DVec3::X * 2.0);
        let angle = (-30.0 + 360.0 * (time - 1.0)).to_radians();
        let on_circle = DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 2.0;
        assert!((p - on_circle).length() < 1e-12, "{time} {p}");
    }
    assert_eq!(motion.at(0.0), turned(-30.0).affine());
    assert_eq!(motion.at(9.0), turned(690.0).affine());
}

#[test]
fn other_axes_are_reached_by_the_shortest_turn_and_opposite_ones_are_the_same() {
    let about = |axis: DVec3, degrees| Pose::new(DVec3::ONE, Some((axis, degrees)), DVec3::ZERO);
    let motion = Motion::new(&[(0.0, about(DVec3::X, 90.0)), (1.0, about(DVec3::Y, 90.0))]).unwrap();
    for i in 0..=8 {
        let m = motion.at(f64::from(i) / 8.0).matrix3;
        assert!((m * m.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-12), "{m}");
    }
    assert!(motion.at(1.0 - 1e-12).abs_diff_eq(motion.at(1.0), 1e-9));
    let motion = Motion::new(&[(0.0, about(DVec3::Z, 10.0)), (1.0, about(-DVec3::Z, 30.0))]).unwrap();
    assert!(motion.at(0.5).matrix3.abs_diff_eq(rotation(DVec3::Z, -10.0), 1e-12));
}

#[test]
fn matrices_are_taken_apart_and_turn_as_well() {
    let stretch = DMat3::from_cols_array(&[2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5]);
    for (size, mirror) in [(1.0, 1.0), (1e-9, 1.0), (1e12, -1.0)] {
        let linear = rotation(DVec3::new(0.6, 0.0, 0.8), 77.0) * stretch * (size * mirror);
        let matrix = DMat4::from_mat3(linear);
        let pose = Pose::of_matrix(matrix).unwrap();
        let error = pose.affine().matrix3 - linear;
        assert!(norm(&error) < 1e-12 * size, "{error}");
        let (axis, degrees) = pose.turn.unwrap();
        assert!((degrees - 77.0).abs() < 1e-9 && axis.abs_diff_eq(DVec3::new(0.6, 0.0, 0.8), 1e-9));
    }
    assert!(Pose::of_matrix(DMat4::ZERO).is_none());
}

#[test]
fn motions_that_cannot_be_are_refused() {
    let scaled = |s: f64| Pose::new(DVec3::new(1.0, s, 1.0), None, DVec3::ZERO);
    assert!(Motion::new(&[]).is_err());
    assert!(Motion::new(&[(0.0, Pose::IDENTITY), (0.0, Pose::IDENTITY)]).is_err());
    assert!(Motion::new(&[(0.0, Pose::IDENTITY), (f64::NAN, Pose::IDENTITY)]).is_err());
    assert!(Motion::new(&[(0.0, scaled(1.0)), (1.0, scaled(-1.0))]).is_err());
    assert!(Motion::new(&[(0.0, scaled(-1.0)), (1.0, scaled(-3.0))]).is_ok());
}

#[test]
fn what_does_not_move_while_the_shutter_is_open_rests() {
    let far = Pose::new(DVec3::ONE, None, DVec3::X);
    let motion = Motion::new(&[(0.0, Pose::IDENTITY), (1.0, far), (2.0, far)]).unwrap();
    assert!(motion.rests([-1.0, 0.0]) && motion.rests([1.0, 2.0]) && motion.rests([0.5, 0.5]));
    assert!(!motion.rests([0.9, 1.1]) && !motion.rests([-1.0, 5.0]));
}

/// The box holds every corner at every time, with no more than a tenth to spare.
#[test]
fn boxes_hold_everything_on_its_way() {
    let pose = |scale: f64, degrees: f64, x: f64| {
        Pose::new(DVec3::new(scale, 1.0, 2.0), Some((DVec3::new(0.6, 0.8, 0.0), degrees)), DVec3::X * x)
    };
    let own = Bounds64 { min: DVec3::new(-1.0, 2.0, 0.5), max: DVec3::new(0.0, 2.5, 3.0) };
    for (poses, shutter) in [
        ([(0.0, pose(1.0, 0.0, 0.0)), (1.0, pose(1.0, 3000.0, 0.0))], [0.2, 0.9]),
        ([(0.0, pose(1.0, 0.0, 0.0)), (1.0, pose(4.0, 90.0, 5.0))], [0.0, 1.0]),
        ([(0.0, pose(1.0, 10.0, 0.0)), (1.0, pose(1.0, 10.0, 5.0))], [-3.0, 0.5]),
    ] {
        let motion = Motion::new(&poses).unwrap();
        let swept = motion.bounds(&own, shutter);
        let mut tight = Bounds64::EMPTY;
        for i in 0..=40_000 {
            let time = shutter[0] + (shutter[1] - shutter[0]) * f64::from(i) / 40_000.0;
            tight = tight.union(&own.moved(&motion.at(time)));
        }
        assert!(tight.min.cmpge(swept.min - 1e-12).all() && tight.max.cmple(swept.max + 1e-12).all());
        let size = (tight.max - tight.min).max_element();
        assert!((tight.min - swept.min).max_element() < 0.1 * size, "{swept:?} {tight:?}");
        assert!((swept.max - tight.max).max_element() < 0.1 * size, "{swept:?} {tight:?}");
    }
}
