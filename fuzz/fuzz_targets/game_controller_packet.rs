#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| naoisis_fuzz::game_controller_packet(bytes));
