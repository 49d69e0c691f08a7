//! The settings of a robot: one list. [`RobotSettings`], its patch, the forms of files and everything that goes over settings are made from it.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Calls the macro `$then` with `$arguments` and the list of a robot's settings, in four groups:
///
/// - `exact`: what a model's file measures, and no realism changes;
/// - `real`: what a [realism](super::Realism) changes, each with the fields by which a model says how a real robot errs (none: the setting
///   as a whole);
/// - `messages`: the same, but in a scenario they are in `messages.robots`, as `messages` are of the match;
/// - `program`: what belongs to the robot's program and not to its model.
macro_rules! robot_settings {
    ($then:ident $arguments:tt) => {
        $then! { $arguments
            exact {
                /// The body.
                body: naoisis_core::robot::body::Body,
                /// The joints of the head.
                head: naoisis_core::robot::head::HeadLimits,
                /// The cameras.
                cameras: naoisis_sensing::sensing::camera::CameraSettings,
            }
            real {
                /// How it walks.
                motion: naoisis_core::robot::motion::MotionLimits ["gait"],
                /// How it kicks.
                kicks: naoisis_core::robot::kick::KickSettings ["direction_sd_deg", "speed_sd"],
                /// What it recognises.
                vision: naoisis_sensing::sensing::vision::VisionSettings ["noise"],
                /// The sonars.
                sonar: naoisis_sensing::sensing::sonar::SonarSettings ["noise"],
                /// How exactly it knows its steps.
                odometry: naoisis_sensing::sensing::odometry::OdometrySettings ["noise"],
                /// How often it falls.
                falls: naoisis_core::robot::falls::FallModel [],
                /// How often it breaks down.
                breakdowns: naoisis_core::robot::condition::Breakdowns [],
                /// The delays of what it sees and does.
                latency: naoisis_core::robot::latency::Latency [],
            }
            messages {
                /// The most that it sends.
                messages: naoisis_core::communication::MessageLimits ["loss"],
            }
            program {
                /// How it localises itself, if it has the built-in belief.
                localisation: naoisis_sensing::belief::localisation_method::LocalisationMethod,
                /// Settings of [sensors that the program has registered](crate::simulation::sensors): what they do not say has its
                /// default, and `null` takes a sensor away. Whether there are such is found when a match starts.
                sensors: naoisis_core::named_values::NamedValues,
            }
        }
    };
}
pub(super) use robot_settings;

macro_rules! settings_and_patch {
    ({} $($group:ident { $($(#[$documentation:meta])* $setting:ident: $type:ty $([$($error:literal),*])?,)* })*) => {
        /// All settings of a robot.
        #[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, JsonSchema)]
        pub struct RobotSettings {
            $($($(#[$documentation])* pub $setting: $type,)*)*
        }

        /// Some settings of a robot: those that it has of its own.
        #[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct RobotPatch {
            $($($(#[$documentation])* #[serde(skip_serializing_if = "Option::is_none")] pub $setting: Option<$type>,)*)*
        }

        impl RobotSettings {
            /// These settings with those of `patch` in their place; of registered sensors, by name.
            #[must_use]
            pub fn patched(&self, patch: &RobotPatch) -> RobotSettings {
                let mut patched = RobotSettings {
                    $($($setting: patch.$setting.as_ref().unwrap_or(&self.$setting).to_owned(),)*)*
                };
                for (name, settings) in &self.sensors.0 {
                    patched.sensors.0.entry(name.clone()).or_insert_with(|| settings.clone());
                }
                patched
            }
        }

        impl RobotPatch {
            /// Whether it changes nothing.
            pub fn is_empty(&self) -> bool {
                *self == Self::default()
            }
        }
    };
}
robot_settings! { settings_and_patch {} }

macro_rules! names_and_components {
    ({}
        exact { $($(#[$exact_meta:meta])* $exact:ident: $exact_type:ty,)* }
        real { $($(#[$real_meta:meta])* $real:ident: $real_type:ty [$($error:literal),*],)* }
        messages { $(#[$messages_meta:meta])* $messages:ident: $messages_type:ty [$($messages_error:literal),*], }
        program { $($(#[$program_meta:meta])* $program:ident: $program_type:ty,)* }
    ) => {
        impl RobotSettings {
            /// The names of settings that no realism changes.
            pub(super) const EXACT: &[&str] = &[$(stringify!($exact)),*];
            /// The names of the settings that a [model](super::RobotModel) has.
            pub(crate) const OF_MODEL: &[&str] =
                &[$(stringify!($exact),)* $(stringify!($real),)* stringify!($messages)];
            /// The names of the settings of a robot's program.
            pub(crate) const OF_PROGRAM: &[&str] = &[$(stringify!($program)),*];
            /// The fields by which a model says how a real robot errs, by setting; of some the setting as a whole.
            pub(super) const ERRORS: &[(&str, &[&str])] = &[
                $((stringify!($real), &[$($error),*]),)*
                (stringify!($messages), &[$($messages_error),*]),
            ];

            /// The components of a robot with these settings.
            pub(crate) fn components(self) -> impl Bundle {
                ($(self.$exact,)* $(self.$real,)* self.$messages)
            }

            /// Gives `robot` the components in which these settings differ from `before`.
            pub(crate) fn change(&self, before: &Self, robot: &mut EntityWorldMut) {
                $(if self.$exact != before.$exact {
                    robot.insert(self.$exact.to_owned());
                })*
                $(if self.$real != before.$real {
                    robot.insert(self.$real.to_owned());
                })*
                if self.$messages != before.$messages {
                    robot.insert(self.$messages);
                }
            }

            /// These settings with those that are among `components`.
            pub(crate) fn with_components(&self, components: &[Box<dyn Reflect>]) -> Self {
                let mut settings = self.clone();
                for component in components {
                    $(if let Some(own) = component.as_any().downcast_ref::<$exact_type>() {
                        settings.$exact = own.to_owned();
                    })*
                    $(if let Some(own) = component.as_any().downcast_ref::<$real_type>() {
                        settings.$real = own.to_owned();
                    })*
                    if let Some(own) = component.as_any().downcast_ref::<$messages_type>() {
                        settings.$messages = *own;
                    }
                }
                settings
            }

            /// Takes the settings that a realism changes from `other`.
            pub(super) fn take_realism_from(&mut self, other: RobotSettings) {
                $(self.$real = other.$real;)*
                self.$messages = other.$messages;
            }

            /// The names of the settings that a realism changes and that differ from `other`'s.
            pub(super) fn real_differences(&self, other: &RobotSettings) -> Vec<&'static str> {
                let differences =
                    [$((stringify!($real), self.$real != other.$real),)* (stringify!($messages), self.$messages != other.$messages)];
                differences.into_iter().filter_map(|(name, differs)| differs.then_some(name)).collect()
            }
        }

        impl RobotPatch {
            /// Whether any setting that a realism changes differs from `other`'s, other than limits of messages.
            pub(super) fn differs_in_realism(&self, other: &RobotPatch) -> bool {
                [$(self.$real != other.$real),*].contains(&true)
            }
        }
    };
}
robot_settings! { names_and_components {} }

/// Defines the form that files have of a type with a [`RobotPatch`]: its own fields and those of the patch beside each other.
macro_rules! patch_beside_fields {
    (
        { $type:ident as $(#[$container:meta])* $form:ident { $($(#[$attribute:meta])* $field:ident: $field_type:ty,)* } }
        $($group:ident { $($(#[$documentation:meta])* $setting:ident: $setting_type:ty $([$($error:literal),*])?,)* })*
    ) => {
        $(#[$container])*
        #[derive(Clone, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub(super) struct $form {
            $($(#[$attribute])* $field: $field_type,)*
            $($($(#[$documentation])* #[serde(skip_serializing_if = "Option::is_none")] $setting: Option<$setting_type>,)*)*
        }

        impl From<$form> for $type {
            fn from(form: $form) -> Self {
                let own = $crate::scenario::RobotPatch { $($($setting: form.$setting,)*)* };
                Self { $($field: form.$field,)* own }
            }
        }

        impl From<$type> for $form {
            fn from(whole: $type) -> Self {
                Self { $($field: whole.$field,)* $($($setting: whole.own.$setting,)*)* }
            }
        }
    };
}
pub(super) use patch_beside_fields;
