//! Colours of jerseys in control packets.

use naoisis_core::game::Game;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::{PerTeam, RobotId};

/// The colours of a team's jerseys.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct TeamColours {
    /// Of field players.
    pub players: Jersey,
    /// Of the goalkeeper.
    pub goalkeeper: Jersey,
}

impl TeamColours {
    /// The colours that the `robots` of a `game` wear: those of its goalkeepers and of the first other robot of each team. A robot without
    /// a jersey counts as one in the colour `team`.
    pub fn worn_by(robots: &[(RobotId, Option<Jersey>)], game: &Game) -> PerTeam<Self> {
        PerTeam::new(|team| {
            let worn = |is_goalkeeper: bool| {
                let mut of_team = robots.iter().filter(move |(id, _)| id.team == team);
                of_team.find(|(id, _)| game.is_goalkeeper(*id) == is_goalkeeper).map(|(_, jersey)| *jersey)
            };
            let [players, goalkeeper] = [worn(false), worn(true)];
            let colour = |jersey: Option<Option<Jersey>>| jersey.flatten().unwrap_or(Jersey::Team).colour_of(team);
            Self { players: colour(players.or(goalkeeper)), goalkeeper: colour(goalkeeper.or(players)) }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn field_players_and_goalkeepers_are_told_by_what_they_wear() {
        let robot = |team, number, jersey| (RobotId::new(team, number), jersey);
        let robots = [
            robot(Team::Blue, 1, Some(Jersey::Yellow)),
            robot(Team::Blue, 2, Some(Jersey::Black)),
            robot(Team::Blue, 3, Some(Jersey::Black)),
            robot(Team::Pink, 2, Some(Jersey::Team)),
        ];
        let of = |blue, pink| {
            let goalkeepers = PerTeam { blue, pink };
            let colours = TeamColours::worn_by(&robots, &Game { goalkeepers, ..Game::default() });
            Team::BOTH.map(|team| (colours[team].players, colours[team].goalkeeper))
        };
        assert_eq!(of(None, None), [(Jersey::Black, Jersey::Yellow), (Jersey::Red, Jersey::Red)]);
        // Another robot keeps the goal.
        assert_eq!(of(Some(3), Some(2)), [(Jersey::Yellow, Jersey::Black), (Jersey::Red, Jersey::Red)]);
        let bare = TeamColours::worn_by(&[], &Game::default());
        assert_eq!([bare.blue.players, bare.pink.goalkeeper], [Jersey::Blue, Jersey::Red]);
    }
}
