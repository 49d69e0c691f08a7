//! The appearance of a robot: its colours, the places of its number, and its limbs in the team's colour.

use bevy::prelude::*;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize, Serializer};
use std::borrow::Cow;

/// A colour: red, green and blue, sRGB, from 0 to 255.
pub type Rgb = [u8; 3];

/// The plastic of a NAO.
const LIGHT: Rgb = [228, 230, 234];
/// Dark shells.
const DARK: Rgb = [74, 78, 86];
/// The joints of a NAO, and the number on its chest.
const JOINT: Rgb = [58, 61, 67];
/// The eyes of a NAO.
const EYE: Rgb = [60, 205, 190];

/// The appearance of a robot, without the dimensions of its body. The band in the team's colour is its body's
/// [waistband](super::body::Waistband).
///
/// In files one of the words `nao`, `light` and `dark`, or an object with the fields that differ from `light`.
#[derive(Clone, Copy, PartialEq, Debug, Reflect)]
pub struct Look {
    /// The shape by which the robot is drawn.
    pub shape: LookShape,
    /// The top of the robot: a head or a mast.
    pub head: Top,
    /// The colour of the robot's shells.
    pub shell: Rgb,
    /// The colour between the shells: joints, wheels, the face.
    pub joints: Rgb,
    /// The colour of the robot's eyes.
    pub eyes: Rgb,
    /// The places of the robot's number.
    pub number: NumberPlaces,
    /// Height of the centre of the number above the ground, m; if absent, derived from the trunk.
    pub number_z_m: Option<f32>,
    /// The colour of the number.
    pub number_colour: Rgb,
    /// The colour of the plates that carry the number.
    pub plates: Rgb,
    /// Limbs whose shells have the team's colour, besides the band. Robots that process images recognise others by the band.
    pub team_limbs: TeamLimbs,
}

impl Look {
    /// A robot with the dimensions of its body and light shells.
    pub const LIGHT: Look = Look {
        shape: LookShape::Measures,
        head: Top::Head,
        shell: LIGHT,
        joints: JOINT,
        eyes: EYE,
        number: NumberPlaces { chest: true, back: true },
        number_z_m: None,
        number_colour: JOINT,
        plates: LIGHT,
        team_limbs: TeamLimbs { head: false, arms: false, legs: false },
    };
    /// The same with dark shells.
    pub const DARK: Look = Look { shell: DARK, joints: LIGHT, ..Look::LIGHT };
    /// The NAO.
    pub const NAO: Look = Look { shape: LookShape::Nao, ..Look::LIGHT };

    /// The looks that have a word in files.
    pub const WORDS: [(&'static str, Look); 3] = [("nao", Look::NAO), ("light", Look::LIGHT), ("dark", Look::DARK)];

    /// The look with this name in files, if there is one.
    pub fn named(word: &str) -> Option<Look> {
        Self::WORDS.into_iter().find(|(name, _)| *name == word).map(|(_, look)| look)
    }
}

impl Default for Look {
    fn default() -> Self {
        Look::LIGHT
    }
}

/// The shape by which a robot is drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LookShape {
    /// The NAO, independently of the dimensions of the body.
    Nao,
    /// The dimensions of its body: a trunk, a head, and its legs and arms, if any.
    Measures,
}

/// The top of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Top {
    /// A head with a face.
    Head,
    /// A mast with a camera.
    Mast,
}

/// The places of a robot's number: a list of `chest` and `back` in files.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Vec<NumberPlace>", into = "Vec<NumberPlace>")]
pub struct NumberPlaces {
    /// On its chest.
    pub chest: bool,
    /// On its back.
    pub back: bool,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum NumberPlace {
    Chest,
    Back,
}

impl From<Vec<NumberPlace>> for NumberPlaces {
    fn from(places: Vec<NumberPlace>) -> Self {
        let has = |place| places.contains(&place);
        Self { chest: has(NumberPlace::Chest), back: has(NumberPlace::Back) }
    }
}

impl From<NumberPlaces> for Vec<NumberPlace> {
    fn from(NumberPlaces { chest, back }: NumberPlaces) -> Self {
        let places = [(chest, NumberPlace::Chest), (back, NumberPlace::Back)];
        places.into_iter().filter_map(|(is_there, place)| is_there.then_some(place)).collect()
    }
}

/// Limbs in the team's colour: a list of `head`, `arms` and `legs` in files.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(from = "Vec<TeamLimb>", into = "Vec<TeamLimb>")]
pub struct TeamLimbs {
    /// The head.
    pub head: bool,
    /// Both arms.
    pub arms: bool,
    /// Both legs, and the feet.
    pub legs: bool,
}

#[derive(Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum TeamLimb {
    Head,
    Arms,
    Legs,
}

impl From<Vec<TeamLimb>> for TeamLimbs {
    fn from(limbs: Vec<TeamLimb>) -> Self {
        let has = |limb| limbs.contains(&limb);
        Self { head: has(TeamLimb::Head), arms: has(TeamLimb::Arms), legs: has(TeamLimb::Legs) }
    }
}

impl From<TeamLimbs> for Vec<TeamLimb> {
    fn from(TeamLimbs { head, arms, legs }: TeamLimbs) -> Self {
        let limbs = [(head, TeamLimb::Head), (arms, TeamLimb::Arms), (legs, TeamLimb::Legs)];
        limbs.into_iter().filter_map(|(is_there, limb)| is_there.then_some(limb)).collect()
    }
}

macro_rules! look_fields {
    ($($(#[$attribute:meta])* $field:ident: $type:ty,)*) => {
        /// A [`Look`] that is an object.
        #[derive(Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        struct LookFields {
            $($(#[$attribute])* $field: $type,)*
        }

        impl From<LookFields> for Look {
            fn from(LookFields { $($field,)* }: LookFields) -> Self {
                Self { $($field,)* }
            }
        }

        impl From<Look> for LookFields {
            fn from(Look { $($field,)* }: Look) -> Self {
                Self { $($field,)* }
            }
        }
    };
}

look_fields! {
    shape: LookShape,
    head: Top,
    shell: Rgb,
    joints: Rgb,
    eyes: Rgb,
    number: NumberPlaces,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 2.5))]
    number_z_m: Option<f32>,
    number_colour: Rgb,
    plates: Rgb,
    team_limbs: TeamLimbs,
}

impl JsonSchema for Look {
    fn schema_name() -> Cow<'static, str> {
        "Look".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let words = Look::WORDS.map(|(word, _)| word);
        json_schema!({
            "description": "One of the words, or an object with the fields that differ from `light`.",
            "anyOf": [{ "enum": words }, generator.subschema_for::<LookFields>()],
        })
    }
}

impl Default for LookFields {
    fn default() -> Self {
        Look::default().into()
    }
}

impl Look {
    /// All fields as an object, even if a word stands for this look.
    pub fn fields(self) -> impl Serialize {
        LookFields::from(self)
    }
}

impl Serialize for Look {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match Self::WORDS.iter().find(|(_, look)| look == self) {
            Some((word, _)) => serializer.serialize_str(word),
            None => LookFields::from(*self).serialize(serializer),
        }
    }
}

word_or_object!(
    Look,
    LookFields,
    "`nao`, `light`, `dark`, or an object such as { \"shell\": [200, 30, 30], \"number\": [\"back\"] }",
    |word, E| Look::named(word).ok_or_else(|| E::unknown_variant(word, &["nao", "light", "dark"]))
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_is_a_word_or_what_differs_from_light() {
        let read = |json: &str| serde_json::from_str::<Look>(json);
        let written = |look: Look| serde_json::to_string(&look).unwrap();
        for (word, look) in Look::WORDS {
            assert_eq!((read(&format!("\"{word}\"")).unwrap(), written(look)), (look, format!("\"{word}\"")));
            // The same look with all its fields.
            assert_eq!(read(&serde_json::to_string(&look.fields()).unwrap()).unwrap(), look);
        }
        let own = read(r#"{ "shell": [200, 30, 30], "number": ["back"], "team_limbs": ["arms"] }"#).unwrap();
        assert_eq!(
            (own.shell, own.joints, own.number),
            ([200, 30, 30], JOINT, NumberPlaces { chest: false, back: true })
        );
        assert!(own.team_limbs.arms && !own.team_limbs.legs);
        assert_eq!(read(&written(own)).unwrap(), own);
        for wrong in
            [r#""drak""#, r#"{ "shel": [0, 0, 0] }"#, r#"{ "shell": [0, 0, 256] }"#, r#"{ "number": ["belly"] }"#]
        {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
