//! How good the image vision is: what it finds in both cameras' images of 500 random scenes, against what is there.
#![expect(clippy::print_stdout, reason = "a benchmark prints its figures")]

use naoisis::internal::appearance::robot::RobotDesign;
use naoisis::random::RandomStream;
use naoisis::sensing::vision::image::accuracy::{self, Conditions};

fn main() {
    // Cargo asks every benchmark binary for its tests too.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    for design in RobotDesign::BOTH {
        let mut stream = RandomStream::for_match(1, "accuracy of image vision");
        let mut conditions = Conditions::default();
        conditions.cameras.design = design;
        let accuracy = accuracy::measure(500, &conditions, &mut stream);
        println!("{design:?} robots\n{accuracy}");
    }
}
