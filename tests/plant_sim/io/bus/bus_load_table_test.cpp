// SPDX-License-Identifier: Apache-2.0
#include "io/bus/bus_load_table.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap;
using namespace voltlap::plant;

TEST_GROUP(BusLoadTable) {
  BusLoad load{10, 500'000};
};

TEST(BusLoadTable, MessagesHaveTheNamesOfTheDbcFiles) {
  STRCMP_EQUAL("CellBroadcast", message_name(0x036).c_str());
  STRCMP_EQUAL("BmsLimits", message_name(0x0C0).c_str());
  STRCMP_EQUAL("CellVoltages_15", message_name(0x20F).c_str());
  STRCMP_EQUAL("-", message_name(0x7FF).c_str());
  STRCMP_EQUAL("-", message_name(0x80000036).c_str());
}

TEST(BusLoadTable, IdentifiersShowHowLongTheyAre) {
  STRCMP_EQUAL("0x036", id_text(0x036).c_str());
  STRCMP_EQUAL("0x00000036", id_text(0x80000036).c_str());
}

TEST(BusLoadTable, PartsOfOneMessageAreOneRow) {
  for (const std::uint32_t id : {0x200U, 0x201U, 0x202U, 0x240U}) {
    Frame f;
    f.id = id;
    load.on_frame(0, Sender::kPlant, f);
  }
  const std::string text = bus_load_table(load.result());
  CHECK(text.find("0x200..202  CellVoltages              3 ") != std::string::npos);
  CHECK(text.find("0x240       Temperatures_00           1 ") != std::string::npos);
}

TEST(BusLoadTable, RowsBeginWithTheLargestShare) {
  Frame limits, broadcast;
  limits.id = 0x0C0;
  broadcast.id = 0x036;
  load.on_frame(0, Sender::kPlant, limits);
  load.on_frame(0, Sender::kBms, broadcast);
  load.on_frame(0, Sender::kBms, broadcast);
  const std::string text = bus_load_table(load.result());
  CHECK(text.find("bus load at 500 kbit/s") != std::string::npos);
  CHECK(text.find("CellBroadcast") < text.find("BmsLimits"));
  CHECK(text.find("BmsLimits") < text.size());
}
