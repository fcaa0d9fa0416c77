// SPDX-License-Identifier: Apache-2.0
#include "codec/message_table.hpp"

#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

TEST_GROUP(MessageTable) {};

TEST(MessageTable, EveryIdentifierFindsItsRowAndNoOtherDoes) {
  std::size_t found = 0;
  const auto look_for = [&found](std::uint32_t id) {
    const std::size_t row = codec::find_row(can::kMessages, codec::kMessageCount, id);
    if (row == codec::kNoRow) return;
    LONGS_EQUAL(id, can::kMessages[row].id);
    CHECK(can::sender_of(id) != can::Node::kNone);
    ++found;
  };
  for (std::uint32_t id = 0; id < 0x800; ++id) look_for(id);
  for (const std::uint32_t id : {can::ChargerCommand::kId, can::ChargerStatus::kId}) {  // those of 29 bits
    look_for(id - 1);
    look_for(id);
    look_for(id + 1);
    look_for(id & ~Frame::kExtendedFlag);
  }
  LONGS_EQUAL(codec::kMessageCount, found);
}

TEST(MessageTable, EmptyTableFindsNothing) { CHECK(codec::find_row(can::kMessages, 0, 0x36) == codec::kNoRow); }

TEST(MessageTable, NoTickCarriesMoreThanTwentyTwoFrames) {
  for (std::size_t cells : {24U, 48U, 49U, 144U}) {
    for (std::uint32_t t = 0; t < 3000; t += 10) {
      int frames = 0;
      for (const can::MessageRow& row : can::kMessages) {
        const bool is_cell = row.id >= can::CellVoltages::kBaseId && row.id < can::CellVoltages::kBaseId + 48;
        if (is_cell && 3 * (row.id - can::CellVoltages::kBaseId) >= cells) continue;
        frames += can::due(t, is_cell ? can::cell_cycle_ms(cells) : row.cycle_ms, row.delay_ms) ? 1 : 0;
      }
      CHECK(frames <= 22);
    }
  }
}
