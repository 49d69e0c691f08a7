use core::fmt::Write;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use naoisis_sim::scenario::RobotModel;

/// Returns the path of a test description.
fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/descriptions").join(name)
}

/// Returns the model after it was written, checked and read again.
fn checked(imported: &Imported) -> RobotModel {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("robot.ron");
    fs::write(&path, &imported.text).unwrap();
    let model = RobotModel::check(&path.to_string_lossy()).unwrap();
    let model = model.unwrap_or_else(|errors| panic!("{}\n{errors:?}", imported.text));
    assert_eq!(model.without_source(), [""; 0], "{}", imported.text);
    model
}

/// Imports a text as a file with this name.
fn import_text(name: &str, text: &str, options: &ImportOptions) -> Result<Imported, DescriptionError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    import(&path, options)
}

fn straight(joint: &str) -> ImportOptions {
    ImportOptions { stand: vec![(joint.to_owned(), 0.0)], ..ImportOptions::default() }
}

/// Returns the numbers at a path such as `body.neck_m`.
fn numbers(model: &RobotModel, path: &str) -> Vec<f64> {
    let settings = Value::Object(model.settings.clone());
    let value = path.split('.').fold(&settings, |value, name| match name.parse::<usize>() {
        Ok(index) => &value[index],
        Err(_) => &value[name],
    });
    match value {
        Value::Array(values) => values.iter().map(|number| number.as_f64().unwrap()).collect(),
        value => vec![value.as_f64().unwrap_or_else(|| panic!("{path}: {value}"))],
    }
}

#[track_caller]
fn assert_figures(model: &RobotModel, figures: &[(&str, &[f64])]) {
    let mut wrong = String::new();
    for (path, expected) in figures {
        let found = numbers(model, path);
        let is_near = |(one, other): (&f64, &f64)| (one - other).abs() < 1.1e-4;
        if found.len() != expected.len() || !found.iter().zip(*expected).all(is_near) {
            let _ = writeln!(wrong, "{path}: {found:?}, expected {expected:?}");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn the_t1_of_a_urdf_has_its_makers_figures() {
    let imported = import(&sample("t1.urdf"), &straight("left_knee_pitch_joint")).unwrap();
    let model = checked(&imported);
    assert_eq!(model.name, "t1");
    // Computed by hand from the joints: the sole is 0.1155 + 0.02 + 0.0819 + 0.134 + 0.28 + 0.012 + 0.0214 + 0.0218 m below the trunk's
    // frame.
    let expected: [(&str, &[f64]); 16] = [
        ("body.legs.hip_m", &[0.014, 0.106, 0.5511]),
        ("body.legs.thigh_m", &[0.2159]),
        ("body.legs.shank_m", &[0.28]),
        ("body.legs.ankle_m", &[0.0553]),
        ("body.foot_y_m", &[0.1063]),
        ("body.neck_m", &[0.014, 0.0, 0.9915]),
        ("body.height_m", &[1.1815]),
        ("body.base.x_m", &[-0.1023, 0.1225]),
        ("body.base.half_width_m", &[0.1563]),
        ("body.torso.x_m", &[-0.0735, 0.0965]),
        ("body.torso.z_m", &[0.5511, 0.9516]),
        ("body.arms.shoulder_m", &[0.009, 0.1533, 0.9056]),
        ("body.arms.length_m", &[0.2076 + 0.185]),
        ("head.yaw_deg", &[-75.0, 75.0]),
        ("head.pitch_deg", &[-20.1, 55.0]),
        ("cameras.mounts.0.tilt_deg", &[8.0]),
    ];
    assert_figures(&model, &expected);
    assert_figures(&model, &[("cameras.mounts.0.position_m", &[0.078, -0.0115, 1.0999])]);
    let source = |path: &str| model.source(path).unwrap().to_owned();
    assert!(source("head.yaw_deg").contains("t1.urdf:") && source("head.yaw_deg").ends_with("joint aahead_yaw_joint"));
    assert!(source("body.legs.hip_m").ends_with("joint left_hip_roll_joint"));
    assert!(source("cameras.mounts").ends_with("head_realsense_rgb_link"));
    // The motor's limit of 41.9 rad/s is not used for the head.
    assert_figures(&model, &[("head.max_degps", &[200.0])]);
    assert!(source("head.max_degps").starts_with("guess: ") && source("motion.max_linear_mps").starts_with("guess: "));
    assert!(imported.lacking.iter().any(|words| words.contains("field of view")), "{:?}", imported.lacking);
}

#[test]
fn the_k1_of_an_mjcf_has_its_figures() {
    let imported = import(&sample("k1.xml"), &straight("Left_Knee_Pitch")).unwrap();
    let model = checked(&imported);
    let expected: [(&str, &[f64]); 15] = [
        ("body.legs.hip_m", &[0.0018, 0.096, 0.4347]),
        ("body.legs.thigh_m", &[0.1655]),
        ("body.legs.shank_m", &[0.2452]),
        ("body.legs.ankle_m", &[0.024]),
        ("body.foot_y_m", &[0.0962]),
        ("body.base.x_m", &[-0.066, 0.094]),
        ("body.base.half_width_m", &[0.1312]),
        ("body.neck_m", &[0.0074, 0.0, 0.7706]),
        ("body.torso.half_width_m", &[0.179]),
        ("body.arms.shoulder_m", &[0.0043, 0.145, 0.6937]),
        ("head.yaw_deg", &[-57.3, 57.3]),
        ("head.pitch_deg", &[-20.0, 49.0]),
        ("cameras.mounts.0.position_m", &[0.0661, 0.0, 0.8691]),
        ("cameras.mounts.0.tilt_deg", &[12.2]),
        ("cameras.diagonal_fov_deg", &[117.7]),
    ];
    assert_figures(&model, &expected);
    assert_figures(&model, &[("cameras.width", &[640.0]), ("cameras.height", &[544.0])]);
    assert_eq!(imported.lacking, [""; 0]);
    assert!(model.source("body.arms.shoulder_m").unwrap().starts_with("k1_arms.xml:"));

    // With bent knees the robot is lower, and its feet are level and below the hips.
    let bent = checked(&import(&sample("k1.xml"), &ImportOptions::default()).unwrap());
    let height = |model: &RobotModel| numbers(model, "body.neck_m")[2];
    let lower = height(&model) - height(&bent);
    // A bend of 0.4 rad lowers it by approximately (0.19 + 0.245) m (1 - cos 0.2).
    assert!((lower - 0.0085).abs() < 0.001, "{lower}");
    assert_figures(&bent, &[("body.legs.ankle_m", &[0.024])]);
    let hip = numbers(&bent, "body.legs.hip_m");
    let ahead = hip[0] - numbers(&model, "body.legs.hip_m")[0];
    assert!(ahead.abs() < 0.006, "the ankle is below the hip: {ahead}");
}

#[test]
fn a_trunk_with_a_head_is_a_robot_that_can_play() {
    let text = r#"<robot name="Little One"><link name="body"><visual><origin xyz="0 0 0.4"/><geometry><box size="0.3 0.2 0.3"/></geometry>
        </visual></link><link name="top"/><joint name="head" type="continuous"><parent link="body"/><child link="top"/><axis xyz="0 0 -1"/></joint></robot>"#;
    let imported = import_text("little.urdf", text, &ImportOptions::default()).unwrap();
    let model = checked(&imported);
    assert_eq!(model.name, "little_one");
    assert_figures(
        &model,
        &[("body.torso.x_m", &[-0.15, 0.15]), ("body.height_m", &[0.375]), ("body.neck_m", &[0.0, 0.0, 0.3])],
    );
    for words in
        ["the head has no shapes", "has no limits", "no camera was found", "no pair of legs", "the neck is a guess"]
    {
        assert!(imported.lacking.iter().any(|line| line.contains(words)), "{words}: {:?}", imported.lacking);
    }
    let nothing = r#"<robot name="n"><link name="a"/></robot>"#;
    let error = import_text("n.urdf", nothing, &ImportOptions::default()).unwrap_err().to_string();
    assert!(error.contains("nothing says how large the robot is"), "{error}");
}

#[test]
fn joints_that_turn_the_other_way_have_turned_limits() {
    let text = fs::read_to_string(sample("t1.urdf")).unwrap();
    let turned = text.replace(
        r#"<axis xyz="0 1 0"/><limit lower="-0.35" upper="0.96""#,
        r#"<axis xyz="0 -1 0"/><limit lower="-0.96" upper="0.35""#,
    );
    assert_ne!(text, turned);
    let model = checked(&import_text("t.urdf", &turned, &ImportOptions::default()).unwrap());
    assert_figures(&model, &[("head.pitch_deg", &[-20.1, 55.0])]);
}

#[test]
fn meshes_that_are_missing_are_named_and_their_boxes_guessed() {
    let text = fs::read_to_string(sample("t1.urdf")).unwrap();
    let mesh = r#"<mesh filename="package://t1_description/meshes/Trunk.STL"/>"#;
    let text = text.replace(r#"<box size="0.17 0.18 0.29"/>"#, mesh);
    let imported = import_text("t.urdf", &text, &ImportOptions::default()).unwrap();
    let model = checked(&imported);
    assert!(
        imported.lacking.iter().any(|words| words.contains("meshes/Trunk.STL cannot be read")),
        "{:?}",
        imported.lacking
    );
    assert!(model.source("body.torso.x_m").unwrap().starts_with("guess: "), "{:?}", model.source("body.torso.x_m"));
}

#[test]
fn cameras_and_joints_can_be_named() {
    let options = ImportOptions {
        cameras: vec!["head_realsense_rgb_link".to_owned()],
        head_yaw: Some("waist_yaw_joint".to_owned()),
        name: Some("mine".to_owned()),
        ..ImportOptions::default()
    };
    let model = checked(&import(&sample("t1.urdf"), &options).unwrap());
    assert_eq!(model.name, "mine");
    assert_figures(&model, &[("head.yaw_deg", &[-58.0, 58.0])]);
    let error = |options: ImportOptions| import(&sample("t1.urdf"), &options).unwrap_err().to_string();
    let camera = error(ImportOptions { cameras: vec!["cam".to_owned()], ..ImportOptions::default() });
    assert_eq!(camera, "there is no camera `cam`; there are head_realsense_rgb_link");
    let joint = error(ImportOptions { head_yaw: Some("neck".to_owned()), ..ImportOptions::default() });
    assert!(joint.starts_with("there is no joint `neck`; there are aahead_yaw_joint, "), "{joint}");
    let axis = error(ImportOptions { head_pitch: Some("waist_yaw_joint".to_owned()), ..ImportOptions::default() });
    assert!(axis.contains("t1.urdf:") && axis.contains("does not turn about the y axis"), "{axis}");
    assert!(error(straight("knee")).contains("there is no joint `knee`"));
}

#[test]
fn what_is_no_description_is_named() {
    let error = |name: &str, text: &str| import_text(name, text, &ImportOptions::default()).unwrap_err().to_string();
    let expected = "expected URDF (<robot>) or MJCF (<mujoco>)";
    assert_eq!(error("a.sdf", "<sdf version='1.6'/>"), format!("a.sdf:1:1: this is an SDF file; {expected}"));
    assert_eq!(error("a.xml", "\n<svg/>"), format!("a.xml:2:1: <svg> is no description of a robot; {expected}"));
    let two = "<robot name='r'><link name='a'/><link name='b'/></robot>";
    assert_eq!(error("a.urdf", two), "a.urdf:1:1: 2 links have no parent: a, b; expected one");
    let joint = |parent: &str, child: &str| {
        format!("<joint name='{parent}{child}' type='fixed'><parent link='{parent}'/><child link='{child}'/></joint>")
    };
    let ring =
        format!("<robot name='r'><link name='a'/><link name='b'/>{}{}</robot>", joint("a", "b"), joint("b", "a"));
    assert!(error("a.urdf", &ring).contains("form a ring"));
    let unknown = format!("<robot name='r'><link name='a'/>\n{}</robot>", joint("a", "b"));
    assert!(error("a.urdf", &unknown).contains("a.urdf:2:") && error("a.urdf", &unknown).contains("no link `b`"));
    let class = "<mujoco><worldbody><body name='a'>\n<geom class='c' size='1'/></body></worldbody></mujoco>";
    assert_eq!(error("a.xml", class), "a.xml:2:1: there is no default class `c`");
    let include = "<mujoco><include file='b.xml'/></mujoco>";
    assert_eq!(error("a.xml", include), "a.xml:1:9: the included file b.xml is not there");
    let itself = "<mujoco>\n<include file='a.xml'/></mujoco>";
    assert_eq!(error("a.xml", itself), "a.xml:2:1: files are included more than 20 deep");
    assert!(error("a.xml", "<mujoco><worldbody/></mujoco>").contains("there is no <body>"));
}

#[test]
fn places_of_mjcf_may_be_said_in_every_way() {
    // A head whose camera looks ahead and 30° down, in five notations; upper-case letters are for fixed axes.
    let ways = [
        ("xyz", r#"xyaxes="0 -1 0 0.5 0 0.8660254""#),
        ("xyz", r#"quat="0.6123724 0.3535534 -0.3535534 -0.6123724""#),
        ("zyx", r#"euler="-90 0 60""#),
        ("XYZ", r#"euler="60 0 -90""#),
        ("xyz", r#"zaxis="-0.8660254 0 0.5""#),
    ];
    for (order, turn) in ways {
        let text = format!(
            r#"<mujoco model="m"><compiler eulerseq="{order}"/>
            <default><geom type="box"/><default class="inner"><geom size="0.1 0.1 0.2"/></default></default>
            <worldbody><body childclass="inner"><freejoint/><geom pos="0 0 0.3"/>
              <frame pos="0 0 0.5"><body><joint name="neck_pitch" axis="0 1 0" range="-10 40"/><camera name="eye" {turn} fovy="60"/></body></frame>
            </body></worldbody></mujoco>"#
        );
        let imported = import_text("m.xml", &text, &ImportOptions::default()).unwrap();
        let model = checked(&imported);
        assert_figures(
            &model,
            &[
                ("body.torso.x_m", &[-0.1, 0.1]),
                ("body.neck_m", &[0.0, 0.0, 0.4]),
                ("head.pitch_deg", &[-10.0, 40.0]),
                ("cameras.mounts.0.tilt_deg", &[30.0]),
            ],
        );
        let is_turned = imported.lacking.iter().any(|words| words.contains("turned by"));
        // The shortest rotation of one axis does not determine the image's right side.
        assert_eq!(is_turned, turn.starts_with("zaxis"), "{turn}: {:?}", imported.lacking);
    }
}

#[test]
fn a_calibration_is_that_of_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("head.yaml");
    let text =
        "width: 640\nheight: 480\nk: [605, 0, 331.5, 0, 611, 247.5, 0, 0, 1]\nd: [0.1, -0.2, 0.001, 0.002, 0.0]\n";
    fs::write(&path, text).unwrap();
    let options = ImportOptions { camera_info: Some(path), ..ImportOptions::default() };
    let imported = import(&sample("t1.urdf"), &options).unwrap();
    let model = checked(&imported);
    assert_figures(&model, &[("cameras.width", &[640.0]), ("cameras.intrinsics.cy", &[247.5])]);
    assert_eq!((imported.lacking.len(), model.measures_of_nao().len()), (0, 0), "{:?}", imported.lacking);
    assert_eq!(model.source("cameras.intrinsics"), Some("head.yaml"));
}

#[test]
fn a_frame_of_a_camera_has_the_image_of_its_sensor() {
    let text = fs::read_to_string(sample("t1.urdf")).unwrap();
    let sensor = r#"<link name="eye"/><joint name="eye_joint" type="fixed"><parent link="head_realsense_rgb_link"/><child link="eye"/></joint>
        <gazebo reference="eye"><sensor type="camera" name="s"><camera><horizontal_fov>1.0</horizontal_fov>
        <image><width>640</width><height>360</height></image></camera></sensor></gazebo></robot>"#;
    let text = text.replace("</robot>", sensor);
    let options = ImportOptions { cameras: vec!["head_realsense_rgb_link".to_owned()], ..ImportOptions::default() };
    let model = checked(&import_text("t.urdf", &text, &options).unwrap());
    // 320 / tan 0.5 = 585.76 pixels; half the diagonal is 367.15.
    assert_figures(&model, &[("cameras.height", &[360.0]), ("cameras.diagonal_fov_deg", &[64.2])]);
}
