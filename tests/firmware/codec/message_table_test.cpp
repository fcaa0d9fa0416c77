// SPDX-License-Identifier: Apache-2.0
#include "codec/message_table.hpp"

#include "base/inverter_protocol.hpp"

#include "can_dbc/car.hpp"
#include "can_dbc/charger.hpp"
#include "can_dbc/pm100.hpp"
#include "codec/amk_frames.hpp"

#include "CppUTest/TestHarness.h"

using namespace voltlap;

namespace {

/// A car has inverters of one kind: their frames are on the bus, and not those of the others.
bool is_of(InverterProtocol protocol, std::uint32_t id) {
  const bool ours = id == can::InverterCommand::kId || id == can::InverterStatus::kId ||
                    id == can::MotorTemperatures::kId;
  const bool pm100 = id >= can::Pm100ModuleTemperatures::kId && id <= can::Pm100Command::kId;
  const bool amk = codec::is_amk(id);
  switch (protocol) {
    case InverterProtocol::kPhaseCurrent: return !pm100 && !amk;
    case InverterProtocol::kPm100: return !ours && !amk;
    case InverterProtocol::kAmk: return !ours && !pm100;
  }
  return false;
}

int frames_at(std::uint32_t now_ms, std::size_t cells, InverterProtocol protocol) {
  int frames = 0;
  for (const can::MessageRow& row : can::kMessages) {
    const bool is_cell = row.id >= can::CellVoltages::kBaseId && row.id < can::CellVoltages::kBaseId + 48;
    if (is_cell && 3 * (row.id - can::CellVoltages::kBaseId) >= cells) continue;
    if (!is_of(protocol, row.id)) continue;
    frames += can::due(now_ms, is_cell ? can::cell_cycle_ms(cells) : row.cycle_ms, row.delay_ms) ? 1 : 0;
  }
  return frames;
}

}  // namespace

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

TEST(MessageTable, NoTickCarriesMoreThanTwentyTwoFramesTwentyFourWithAPm100OrTwentyEightWithAnAmk) {
  for (std::size_t cells : {24U, 48U, 49U, 144U}) {
    for (std::uint32_t t = 0; t < 3000; t += 10) {
      CHECK(frames_at(t, cells, InverterProtocol::kPhaseCurrent) <= 22);
      CHECK(frames_at(t, cells, InverterProtocol::kPm100) <= 24);
      CHECK(frames_at(t, cells, InverterProtocol::kAmk) <= 28);
    }
  }
}
