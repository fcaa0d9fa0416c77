// SPDX-License-Identifier: Apache-2.0
// Signals of recordings whose DBC says less than, or something else than, what the sender means.
#include "io/logs/signal_tap.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>

#include "plant_sim/core/scratch.hpp"
#include "plant_sim/io/logs/dbc_cache.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(SignalTap) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  TEST_SETUP() { use_dbc_cache_of_this_run(); }

  /// A role from one signal of frame 0x100 with `bytes` bytes, Intel; `raw` gives it for each of 400 frames.
  DriveLog read(const char* role, const char* signal, int bytes, const std::function<unsigned(int)>& raw,
                const char* more = "", const char* unit = "1") {
    scratch.write("a.dbc",
                  fmt::format("BO_ 256 F: 8 X\n SG_ S : {} X\n SG_ Rest : 56|8@1+ (1,0) [0|0] \"\" X\n{}", signal,
                              comment));
    std::string text;
    for (int k = 0; k < 400; ++k) {
      text += fmt::format("({:.3f}) can0 100#", 0.1 * k);
      for (int b = 0; b < 8; ++b) text += fmt::format("{:02X}", b < bytes ? raw(k) >> 8 * b & 0xFF : 0);
      text += "\n";
    }
    const RoleMap map = load_role_map(scratch.write(
        "map.toml", fmt::format("[roles]\n{} = {{frame = 0x100, signal = \"S\", dbc = \"a.dbc\", unit = \"{}\"{}}}\n",
                                role, unit, more)));
    return read_drive_log(scratch.write("a.log", text), &map, data);
  }
  static std::size_t masked(const DriveLog& log) {
    std::size_t out = 0;
    for (const MaskedStretch& stretch : log.masked) out += stretch.count;
    return out;
  }
  static std::string words(const DriveLog& log) {
    std::string out;
    for (const LogDefect& defect : log.defects) out += defect.text + "\n";
    return out;
  }
  static double highest(const Channel& channel) {
    double out = -1e300;
    for (const double value : channel.value) out = std::isfinite(value) ? std::max(out, value) : out;
    return out;
  }
  std::string comment;
};

TEST(SignalTap, FullThrottleIsFullThrottle) {
  const auto on_and_off = [](int k) { return k / 50 % 2 == 0 ? 0U : 255U; };
  const auto ramp = [](int k) { return static_cast<unsigned>(std::min(255, std::abs(k % 200 - 100) * 3)); };
  const auto noisy = [](int k) { return k / 50 % 2 == 0 ? static_cast<unsigned>(k % 3) : 255U; };
  for (const auto& raw : {std::function<unsigned(int)>(on_and_off), std::function<unsigned(int)>(ramp),
                          std::function<unsigned(int)>(noisy)}) {
    for (const char* range : {"[0|100]", "[0|0]", "[0|255]"}) {
      const DriveLog log =
          read("accelerator", fmt::format("0|8@1+ (0.392157,0) {} \"%\"", range).c_str(), 1, raw, "", "%");
      LONGS_EQUAL(0, masked(log));
      LONGS_EQUAL(0, log.defects.size());
      DOUBLES_EQUAL(1.0, highest(log.channels.at("accelerator")), 1e-6);
    }
  }
}

TEST(SignalTap, AllOnesBeyondTheRangeAndForMomentsAreNoValueAndItIsSaid) {
  const auto dropouts = [](int k) { return k % 40 == 17 ? 0xFFFFU : 9600U + static_cast<unsigned>(k * 7 % 13); };
  DriveLog log = read("pack_voltage", "0|16@1+ (0.01,0) [0|600] \"V\"", 2, dropouts, "", "V");
  LONGS_EQUAL(10, masked(log));
  STRCMP_CONTAINS("all ones, taken as no value: beyond the DBC's range", words(log).c_str());
  log = read("pack_voltage", "0|16@1+ (0.01,0) [0|0] \"V\"", 2, dropouts, "", "V");
  LONGS_EQUAL(10, masked(log));
  STRCMP_CONTAINS("all ones, taken as no value: there for moments only", words(log).c_str());
  DOUBLES_EQUAL(96.12, highest(log.channels.at("pack_voltage")), 1e-9);
  log = read("current", "0|12@1- (0.5,0) [-400|200] \"A\"", 2,
             [](int k) { return k % 40 == 17 ? 0x7FFU : static_cast<unsigned>(k * 7 % 13); }, "", "A");
  STRCMP_CONTAINS("end of the raw values, taken as no value: beyond the DBC's range", words(log).c_str());
}

TEST(SignalTap, CodesOfTheFileAndOfTheMapAreInvalid) {
  const auto raw = [](int k) { return k % 40 == 17 ? 500U : k % 3 == 0 ? 100U : 101U; };
  comment = "CM_ SG_ 256 S \"500 means sensor error\";\n";
  STRCMP_CONTAINS("10 of 400 samples: invalid code",
                  words(read("pack_voltage", "0|16@1+ (1,0) [0|0] \"V\"", 2, raw, "", "V")).c_str());
  comment = "VAL_ 256 S 500 \"Signal_Not_Available\" ;\n";
  STRCMP_CONTAINS("10 of 400 samples: invalid code",
                  words(read("pack_voltage", "0|16@1+ (1,0) [0|0] \"V\"", 2, raw, "", "V")).c_str());
  comment = "";
  const DriveLog log = read("pack_voltage", "0|16@1+ (0.1,0) [0|0] \"V\"", 2, raw, ", invalid = [50.0]", "V");
  STRCMP_CONTAINS("10 of 400 samples: invalid code", words(log).c_str());
}

TEST(SignalTap, CurrentDeclaredUnsignedIsReadAsSignedAndItIsSaid) {
  const auto turns = [](int k) { return k / 50 % 2 == 0 ? 0xFED4U : 1000U; };
  const auto sine = [](int k) { return static_cast<unsigned>(std::lround(800 * std::sin(k / 9.0))) & 0xFFFFU; };
  const auto around_zero = [](int k) { return static_cast<unsigned>(k % 5 - 2) & 0xFFFFU; };
  for (const auto& raw : {std::function<unsigned(int)>(turns), std::function<unsigned(int)>(sine),
                          std::function<unsigned(int)>(around_zero)}) {
    const DriveLog log = read("current", "0|16@1+ (0.1,0) [-3000|3000] \"A\"", 2, raw, "", "A");
    const Channel& current = log.channels.at("current");
    LONGS_EQUAL(0, masked(log));
    for (int k = 0; k < 400; ++k) {
      DOUBLES_EQUAL(0.1 * static_cast<std::int16_t>(raw(k)), current.value[static_cast<std::size_t>(k)], 1e-9);
    }
    STRCMP_CONTAINS("current (0x100 S): declared unsigned, but its values wrap around 0 as a signed one does",
                    words(log).c_str());
    STRCMP_CONTAINS("a.dbc:2", words(log).c_str());
  }
}

TEST(SignalTap, SignThatTheValuesLeaveOpenIsRefusedUnlessTheMapSaysIt) {
  const auto turns = [](int k) { return k / 50 % 2 == 0 ? 0xFD4U : 1000U; };  // 405.2 or -4.4 A, and 100 A
  const char* signal = "0|12@1+ (0.1,0) [0|0] \"A\"";
  const std::string text = complaint([&] { (void)read("current", signal, 2, turns, "", "A"); });
  STRCMP_CONTAINS("a.dbc:2: found signal S, declared unsigned, whose values jump 7 times", text.c_str());
  STRCMP_CONTAINS("up to 405.2 A as it stands, down to -4.4 A if it is signed", text.c_str());
  DOUBLES_EQUAL(405.2, highest(read("current", signal, 2, turns, ", min = 0", "A").channels.at("current")), 1e-9);
  DOUBLES_EQUAL(100.0, highest(read("current", signal, 2, turns, ", max = 300", "A").channels.at("current")), 1e-9);
}

TEST(SignalTap, FrameThatTheDbcHasTwiceIsRefusedWhenTheMapAsksForIt) {
  comment = "BO_ 256 G: 8 X\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" X\n";
  STRCMP_CONTAINS("a.dbc:4: found frame 0x100 for the second time", complaint([&] {
                    (void)read("current", "0|16@1- (0.1,0) [0|0] \"A\"", 2, [](int) { return 1U; }, "", "A");
                  }).c_str());
}
