// SPDX-License-Identifier: Apache-2.0
// Frames of a pack, and the drive that is read from them, for the tests of drives.
#pragma once
#include <fmt/format.h>

#include <string>

#include "io/logs/drive_log.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/io/logs/dbc_cache.hpp"

#include <CppUTest/TestHarness.h>

// Current and voltage every 10 ms, cells one a frame, a counter; Motorola, as an Orion has them.
inline constexpr const char* kDbc =
    "BO_ 256 Pack: 8 X\n SG_ I : 7|16@0- (0.1,0) [0|0] \"A\" X\n SG_ U : 23|16@0+ (0.1,0) [0|0] \"V\" X\n"
    " SG_ Count : 35|4@0+ (1,0) [0|0] \"\" X\n SG_ Sum : 63|8@0+ (1,0) [0|0] \"\" X\n"
    "BO_ 257 Cell: 8 X\n SG_ Id : 7|8@0+ (1,0) [0|0] \"\" X\n SG_ V : 15|16@0+ (0.0001,0) [0|0] \"V\" X\n"
    "BO_ 258 Many: 8 X\n SG_ Mux M : 7|8@0+ (1,0) [0|0] \"\" X\n SG_ Cell01 m0 : 15|16@0+ (0.0001,0) [0|0] \"V\" "
    "X\n"
    " SG_ Cell02 m1 : 15|16@0+ (0.0001,0) [0|0] \"V\" X\n";

inline std::string pack_frame(double time_s, int tenth_amperes, int tenth_volts, int counter, bool good_sum = true) {
  const unsigned i = static_cast<unsigned>(tenth_amperes) & 0xFFFFU, u = static_cast<unsigned>(tenth_volts);
  const unsigned bytes[7] = {i >> 8, i & 0xFF, u >> 8, u & 0xFF, static_cast<unsigned>(counter) & 0xFU, 0, 0};
  unsigned sum = 0x100 + 8;
  std::string data;
  for (const unsigned byte : bytes) {
    sum += byte;
    data += fmt::format("{:02X}", byte);
  }
  return fmt::format("({:.3f}) can0 100#{}{:02X}\n", time_s, data, (good_sum ? sum : sum + 1) & 0xFF);
}

inline std::string cell_frame(double time_s, int id, int raw) {
  return fmt::format("({:.3f}) can0 101#{:02X}{:04X}0000000000\n", time_s, id, raw);
}

struct DriveFrames : Utest {
  Scratch scratch;
  voltlap::plant::DataFolder data{VOLTLAP_DATA_FOLDER};
  void setup() override { use_dbc_cache_of_this_run(); }
  voltlap::plant::RoleMap map_of(const std::string& roles) {
    scratch.write("a.dbc", kDbc);
    return voltlap::plant::load_role_map(scratch.write("map.toml", "[roles]\n" + roles));
  }
  voltlap::plant::RoleMap pack_map() {
    return map_of(
        "current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\", counter = \"Count\", checksum = \"orion\"}\n"
        "pack_voltage = {frame = 0x100, signal = \"U\", dbc = \"a.dbc\"}\n");
  }
  /// A square wave of 20 A on 100 V with 0.1 ohm.
  std::string square(int frames, double start_s = 1000.0) {
    std::string text;
    for (int k = 0; k < frames; ++k) {
      const bool on = k / 20 % 2 == 1;
      text += pack_frame(start_s + 0.01 * k, on ? 200 : 0, on ? 980 : 1000, k);
    }
    return text;
  }
  voltlap::plant::DriveLog read(const std::string& text, const voltlap::plant::RoleMap& map) {
    return voltlap::plant::read_drive_log(scratch.write("a.log", text), &map, data);
  }
  const voltlap::plant::LogDefect* defect(const voltlap::plant::DriveLog& log, const std::string& kind) {
    for (const voltlap::plant::LogDefect& found : log.defects) {
      if (found.kind == kind) return &found;
    }
    return nullptr;
  }
  bool is_masked(const voltlap::plant::DriveLog& log, const char* channel, const char* reason) {
    for (const voltlap::plant::MaskedStretch& stretch : log.masked) {
      if (stretch.channel == channel && stretch.reason == reason) return true;
    }
    return false;
  }
};
