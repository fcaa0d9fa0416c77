// SPDX-License-Identifier: Apache-2.0
#include "codec/seal.hpp"

#include "base/require.hpp"
#include "codec/crc8.hpp"

namespace voltlap::codec {
namespace {

const can::MessageRow* row_of(const Frame& frame) {
  const std::size_t row = find_row(can::kMessages, kMessageCount, frame.id);
  return row == kNoRow ? nullptr : &can::kMessages[row];
}

/// Identifier, high byte first, then every byte of the payload but the one that holds the CRC.
std::uint8_t crc_of(const can::MessageRow& row, const Frame& frame) {
  std::uint8_t crc = kCrc8Start;
  crc = crc8_step(crc, static_cast<std::uint8_t>(frame.id >> 8));
  crc = crc8_step(crc, static_cast<std::uint8_t>(frame.id));
  for (std::uint8_t i = 0; i < row.dlc; ++i) {
    if (i != row.crc_byte) crc = crc8_step(crc, frame.data[i]);
  }
  return crc8_finish(crc);
}

/// Orion: (identifier + 8 + bytes 0 to 6) modulo 256.
std::uint8_t orion_sum_of(const can::MessageRow& row, const Frame& frame) {
  std::uint32_t sum = frame.id + 8U;
  for (std::uint8_t i = 0; i < row.dlc; ++i) {
    if (i != row.crc_byte) sum += frame.data[i];
  }
  return static_cast<std::uint8_t>(sum);
}

}  // namespace

void seal(const can::MessageRow& row, Frame& frame, std::uint8_t counter) {
  VOLTLAP_REQUIRE(frame.id == row.id);
  if (row.protection == can::Protection::kCounterCrc) {
    frame.data[row.counter_byte] = counter;
    frame.data[row.crc_byte] = crc_of(row, frame);
  }
  if (row.protection == can::Protection::kOrionSum) frame.data[row.crc_byte] = orion_sum_of(row, frame);
}

void seal(Frame& frame, std::uint8_t counter) {
  if (const can::MessageRow* row = row_of(frame)) seal(*row, frame, counter);
}

bool sealed_ok(const can::MessageRow& row, const Frame& frame) {
  if (frame.id != row.id || frame.dlc != row.dlc) return false;
  switch (row.protection) {
    case can::Protection::kNone: break;
    case can::Protection::kCounterCrc: return frame.data[row.crc_byte] == crc_of(row, frame);
    case can::Protection::kOrionSum: return frame.data[row.crc_byte] == orion_sum_of(row, frame);
    case can::Protection::kAge: return true;
  }
  return false;
}

bool sealed_ok(const Frame& frame) {
  const can::MessageRow* row = row_of(frame);
  return row != nullptr && sealed_ok(*row, frame);
}

std::uint8_t counter_of(const can::MessageRow& row, const Frame& frame) {
  return row.protection == can::Protection::kCounterCrc ? frame.data[row.counter_byte] : std::uint8_t{0};
}

std::uint8_t counter_of(const Frame& frame) {
  const can::MessageRow* row = row_of(frame);
  return row == nullptr ? std::uint8_t{0} : counter_of(*row, frame);
}

void Sealer::seal(Frame& frame) {
  const std::size_t row = find_row(can::kMessages, kMessageCount, frame.id);
  if (row == kNoRow) return;
  codec::seal(can::kMessages[row], frame, next_[row]);
  next_[row] = static_cast<std::uint8_t>(next_[row] + 1U);
}

}  // namespace voltlap::codec
