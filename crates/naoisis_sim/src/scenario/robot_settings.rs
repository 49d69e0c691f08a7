//! The settings of a robot, in a single list. [`RobotSettings`], its patch, the forms in files and all code for each setting are generated
//! from it.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Calls the macro `$then` with `$arguments` and the list of a robot's settings, in four groups:
///
/// - `exact`: measured in a model's file, and independent of the realism;
/// - `real`: depends on the [realism](super::Realism). Each has the fields for the errors of a real robot (none: the setting as a whole);
/// - `messages`: like `real`, but in `messages.robots` of a scenario, since its `messages` belong to the match;
/// - `program`: belongs to the robot's program and not to its model.
macro_rules! robot_settings {
    ($then:ident $arguments:tt) => {
        $then! { $arguments
            exact {
                /// The body.
                body: naoisis_core::robot::body::Body,
                /// The joints of the head.
                head: naoisis_core::robot::head::HeadLimits,
            }
            real {
                /// The cameras.
                cameras: naoisis_sensing::sensing::camera::CameraSettings ["lens", "noise"],
                /// How it walks.
                motion: naoisis_core::robot::motion::MotionSettings ["gait"],
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
                /// How well it hears whistles.
                hearing: naoisis_core::referee::hearing::Hearing [],
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

        /// Settings of a robot that differ from the common ones.
        #[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct RobotPatch {
            $($($(#[$documentation])* #[serde(skip_serializing_if = "Option::is_none")] pub $setting: Option<$type>,)*)*
        }

        impl RobotSettings {
            /// Returns these settings, replaced by those of `patch` where it has any. Registered sensors are replaced by name.
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
            /// Returns whether the patch changes nothing.
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
            /// Names of the settings that do not depend on the realism.
            pub(super) const EXACT: &[&str] = &[$(stringify!($exact)),*];
            /// Names of the settings that a [model](super::RobotModel) has.
            pub(crate) const OF_MODEL: &[&str] =
                &[$(stringify!($exact),)* $(stringify!($real),)* stringify!($messages)];
            /// Names of the settings of a robot's program.
            pub(crate) const OF_PROGRAM: &[&str] = &[$(stringify!($program)),*];
            /// For each setting, the fields of a model for the errors of a real robot. Empty if the setting as a whole describes them.
            pub(super) const ERRORS: &[(&str, &[&str])] = &[
                $((stringify!($real), &[$($error),*]),)*
                (stringify!($messages), &[$($messages_error),*]),
            ];

            /// Returns the components of a robot with these settings.
            pub(crate) fn components(self) -> impl Bundle {
                ($(self.$exact,)* $(self.$real,)* self.$messages)
            }

            /// Inserts the components for which these settings differ from `before`.
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

            /// Returns these settings, replaced by those among `components`.
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

            /// Replaces the settings that depend on the realism by those of `other`.
            pub(super) fn take_realism_from(&mut self, other: RobotSettings) {
                $(self.$real = other.$real;)*
                self.$messages = other.$messages;
            }

            /// Returns the names of the settings that depend on the realism and differ from those of `other`.
            pub(super) fn real_differences(&self, other: &RobotSettings) -> Vec<&'static str> {
                let differences =
                    [$((stringify!($real), self.$real != other.$real),)* (stringify!($messages), self.$messages != other.$messages)];
                differences.into_iter().filter_map(|(name, differs)| differs.then_some(name)).collect()
            }
        }

        impl RobotPatch {
            /// Returns whether a setting that depends on the realism differs from that of `other`, except for message limits.
            pub(super) fn differs_in_realism(&self, other: &RobotPatch) -> bool {
                [$(self.$real != other.$real),*].contains(&true)
            }
        }
    };
}
robot_settings! { names_and_components {} }

/// Defines the file form of a type with a [`RobotPatch`], with the type's own fields and those of the patch side by side.
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
