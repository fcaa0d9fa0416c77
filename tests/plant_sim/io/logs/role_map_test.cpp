// SPDX-License-Identifier: Apache-2.0
#include "io/logs/role_map.hpp"

#include "plant_sim/core/scratch.hpp"

#include <filesystem>

#include <fmt/format.h>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(RoleMap) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  MeasuredTable table_of(const std::string& header, const std::string& row) {
    return read_measured_table(scratch.write("table.csv", header + "\n" + row + "\n"));
  }
  std::string complaint_of(const std::string& map) {
    const std::string path = scratch.write("map.toml", map);
    return complaint([&] { (void)load_role_map(path); });
  }
};

TEST(RoleMap, ScaleOffsetAndUnitLeadToSi) {
  const RoleMap map = load_role_map(scratch.write(
      "map.toml",
      "[roles]\ncurrent = {column = \"I\", unit = \"mA\", scale = 10, offset = 5, discharge = \"-\"}\n"
      "temperature_1 = {column = \"T\", unit = \"degF\"}\n"));
  DOUBLES_EQUAL(0.01, map.find("current")->scale, 1e-15);
  DOUBLES_EQUAL(0.005, map.find("current")->offset, 1e-15);
  CHECK(map.find("current")->discharge == DischargeSign::kNegative);
  DOUBLES_EQUAL(100.0, 212.0 * map.find("temperature_1")->scale + map.find("temperature_1")->offset, 1e-12);
  POINTERS_EQUAL(nullptr, map.find("voltage"));
}

TEST(RoleMap, PlainColumnNamesNeedNoMap) {
  const RoleMap map = role_map_for(table_of("time_s,current_ma,voltage_v,temperature_c", "0,1,3,25"), data);
  STRCMP_EQUAL("current_ma", map.find("current")->column.c_str());
  DOUBLES_EQUAL(1e-3, map.find("current")->scale, 1e-15);
  CHECK(map.find("temperature_1") != nullptr);
}

TEST(RoleMap, ShippedMapIsFoundByItsHeader) {
  const RoleMap map = role_map_for(table_of("t_s,i_a,v_v,temp_c,ah_out", "0,1,3,25,0"), data);
  STRCMP_CONTAINS("panasonic_18650pf", map.source.c_str());
  CHECK(map.find("charge_ah") != nullptr);
}

TEST(RoleMap, EveryShippedMapIsRead) {
  const auto names = data.names("maps");
  CHECK(names.size() >= 4);
  for (const std::string& name : names)
    CHECK(load_role_map(data.find("maps", name, "test")).find("current") != nullptr);
}

TEST(RoleMap, UnknownColumnsGiveADraftMap) {
  std::string rows = "Zeitx,Stromwert?,Spann\n";
  for (int row = 0; row < 50; ++row) rows += fmt::format("{},{},{}\n", row, row % 7, 90.0 - row % 7);
  const MeasuredTable table = read_measured_table(scratch.write("table.csv", rows));
  const std::string message = complaint([&] { (void)role_map_for(table, data); });
  STRCMP_CONTAINS("current = {column = \"Stromwert?\"", message.c_str());
  STRCMP_CONTAINS("time = {column = \"Zeitx\"", message.c_str());
}

TEST(RoleMap, UnknownRoleUnitKeyAndSignAreNamed) {
  STRCMP_CONTAINS("roles.curent", complaint_of("[roles]\ncurent = {column = \"I\"}\n").c_str());
  STRCMP_CONTAINS("wheel_speed_0", complaint_of("[roles]\nwheel_speed_0 = {column = \"I\"}\n").c_str());
  STRCMP_CONTAINS("furlong", complaint_of("[roles]\ncurrent = {column = \"I\", unit = \"furlong\"}\n").c_str());
  STRCMP_CONTAINS("gain", complaint_of("[roles]\ncurrent = {column = \"I\", gain = 2}\n").c_str());
  STRCMP_CONTAINS("discharge",
                  complaint_of("[roles]\ncurrent = {column = \"I\", discharge = \"minus\"}\n").c_str());
  STRCMP_CONTAINS("no [roles]", complaint_of("match = [\"a\"]\n").c_str());
  STRCMP_CONTAINS("Write [roles] before it", complaint_of("current = {column = \"I\"}\n").c_str());
  STRCMP_CONTAINS("no signal", complaint_of("[roles]\ncurrent = {frame = 1, dbc = \"a.dbc\"}\n").c_str());
  STRCMP_CONTAINS("11 or 29 bits", complaint_of("[roles]\ncurrent = {frame = 0x20000000, signal = \"I\", dbc = "
                                                "\"a.dbc\"}\n")
                                       .c_str());
  STRCMP_CONTAINS("checksum = 'md5'",
                  complaint_of("[roles]\ncurrent = {frame = 1, signal = \"I\", dbc = \"a.dbc\", "
                               "checksum = \"md5\"}\n")
                      .c_str());
  STRCMP_CONTAINS("only for a role with <n>",
                  complaint_of("[roles]\nsoc = {column = \"v\", index = \"n\"}\n").c_str());
}

TEST(RoleMap, FrameOfElevenAndOfTwentyNineBits) {
  const RoleMap map =
      load_role_map(scratch.write("map.toml",
                                  "[roles]\ncurrent = {frame = 0x6B0, signal = \"I\", dbc = \"a.dbc\"}\n"
                                  "pack_voltage = {frame = 0x1838F380, signal = \"U\", dbc = \"a.dbc\"}\n"
                                  "soc = {frame = 0x6B0, extended = true, signal = \"S\", dbc = \"a.dbc\"}\n"));
  CHECK_EQUAL(0x6B0U, *map.find("current")->frame);
  CHECK_EQUAL(0x9838F380U, *map.find("pack_voltage")->frame);
  CHECK_EQUAL(0x800006B0U, *map.find("soc")->frame);
}

TEST(RoleMap, PathsAreRelativeToTheMapAndTheDataFolderIsExpanded) {
  RoleMap map;
  map.source = "/maps/a.toml";
  STRCMP_EQUAL("/maps/b/c.dbc", path_in_map(map, "b/c.dbc").c_str());
  STRCMP_EQUAL("/c.dbc", path_in_map(map, "/c.dbc").c_str());
  ::setenv("VOLTLAP_DATA", "/measured", 1);
  STRCMP_EQUAL("/measured/x.csv", path_in_map(map, "$VOLTLAP_DATA/x.csv").c_str());
  ::unsetenv("VOLTLAP_DATA");
  STRCMP_CONTAINS("VOLTLAP_DATA is not set",
                  complaint([&] { (void)path_in_map(map, "$VOLTLAP_DATA/x.csv"); }).c_str());
}

TEST(RoleMap, EveryMistakeOfAFileIsSaidWithItsLine) {
  const std::string message = complaint_of(
      "[roles]\ncurrent = {column = \"I\", scale = \"2\", discharge = 1, invalid = \"255\", unit = \"degC\"}\n"
      "\nsoc = {column = 7, unit = \"V\", min = true}\n");
  for (const char* expected : {":2: roles.current.scale", ":2: roles.current.discharge", ":2: roles.current.invalid",
                               ":2: roles.current.unit", ":4: roles.soc.column", ":4: roles.soc.unit",
                               ":4: roles.soc.min"}) {
    STRCMP_CONTAINS(expected, message.c_str());
  }
}

TEST(RoleMap, ValuesOfARightTypeThatMakeNoSenseAreRefused) {
  const struct {
    const char *entry, *key;
  } wrong[] = {{"current = {column = \"I\", scale = 0}", "scale"},
               {"current = {column = \"I\", scale = inf}", "scale"},
               {"current = {column = \"I\", offset = nan}", "offset"},
               {"current = {column = \"\"}", "column"},
               {"current = {column = \"I<n>\"}", "column"},
               {"current = {column = \"I\", min = 5, max = 5}", "max"},
               {"current = {column = \"I\", shift_s = \"1\"}", "shift_s"},
               {"current = {column = \"I\", invalid = [\"x\"]}", "invalid"},
               {"current = \"I\"", "current"},
               {"soc = {column = \"s\", discharge = \"+\"}", "discharge"},
               {"time = {frame = 1, signal = \"t\", dbc = \"a.dbc\"}", "frame"},
               {"\"cell_voltage_<n>\" = {column = \"v\"}", "column"},
               {"\"cell_voltage_<n>\" = {column = \"v\", index = \"n\", first = 1.5}", "first"},
               {"current = {frame = 1.0, signal = \"I\", dbc = \"a.dbc\"}", "frame"},
               {"current = {frame = -1, signal = \"I\", dbc = \"a.dbc\"}", "frame"},
               {"current = {frame = \"0x1\", signal = \"I\", dbc = \"a.dbc\"}", "frame"},
               {"current = {frame = 1, signal = 2, dbc = \"a.dbc\"}", "signal"},
               {"current = {frame = 1, extended = 1, signal = \"I\", dbc = \"a.dbc\"}", "extended"},
               {"current = {frame = 1, signal = \"I\", dbc = \"a.dbc\", bus = 0}", "bus"},
               {"current = {frame = 1, signal = \"I\", dbc = \"a.dbc\", period_s = 0}", "period_s"},
               {"current = {frame = 1, signal = \"I\", dbc = \"a.dbc\", last_frame = 2}", "last_frame"},
               {"\"cell_voltage_<n>\" = {frame = 1, signal = \"U<n>\", dbc = \"a.dbc\", last_frame = 1}", "last_frame"},
               {"\"cell_voltage_<n>\" = {frame = 1, signal = \"U<n>\", dbc = \"a.dbc\", last_frame = 0x800}",
                "last_frame"},
               {"current = {frame = 1, signal = \"I\", dbc = \"a.dbc\", column = \"I\"}", "column"}};
  for (const auto& [entry, key] : wrong) {
    const std::string message = complaint_of(std::string("[roles]\n\n") + entry + "\n");
    CHECK_TEXT(message.find(":3: roles.") != std::string::npos, (entry + (" -> " + message)).c_str());
    CHECK_TEXT(message.find(key) != std::string::npos, message.c_str());
  }
  STRCMP_CONTAINS(":1: match", complaint_of("match = \"a,b\"\n[roles]\nsoc = {column = \"s\"}\n").c_str());
  STRCMP_CONTAINS(":1: match_frames", complaint_of("match_frames = [-1]\n[roles]\nsoc = {column = \"s\"}\n").c_str());
}

TEST(RoleMap, NumbersMayGoOnFromFrameToFrame) {
  const RoleMap map = load_role_map(scratch.write(
      "map.toml",
      "[roles]\n\"cell_voltage_<n>\" = {frame = 0x10010, last_frame = 0x10013, signal = \"U<n>\", dbc = \"a.dbc\"}\n"));
  CHECK_EQUAL(0x80010010U, *map.find("cell_voltage_<n>")->frame);
  CHECK_EQUAL(0x80010013U, *map.find("cell_voltage_<n>")->last_frame);
  const RoleMap indexed = load_role_map(scratch.write(
      "map.toml",
      "[roles]\n\"temperature_<n>\" = {frame = 1, last_frame = 2, signal = \"T\", index = \"N\", dbc = \"a.dbc\"}\n"));
  CHECK_EQUAL(2U, *indexed.find("temperature_<n>")->last_frame);
}

TEST(RoleMap, ColumnsThatAMapAsksForAreTexts) {
  for (const char* value : {"[\"t\", 3]", "\"t\""}) {
    const std::string map = fmt::format("match_columns = {}\n[roles]\nsoc = {{column = \"s\"}}\n", value);
    STRCMP_CONTAINS("match_columns", complaint_of(map).c_str());
  }
}

TEST(RoleMap, ShippedMapsNeedNoFolderOfMeasuredDataForCan) {
  ::unsetenv("VOLTLAP_DATA");
  for (const std::string& name : data.names("maps")) {
    const RoleMap map = load_role_map(data.find("maps", name, "test"));
    for (const auto& [role, source] : map.roles) {
      if (source.frame) CHECK_TEXT(std::filesystem::exists(path_in_map(map, source.dbc)), (name + " " + role).c_str());
    }
  }
}
