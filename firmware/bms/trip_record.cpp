// SPDX-License-Identifier: Apache-2.0
#include "bms/trip_record.hpp"

#include "codec/crc8.hpp"

namespace voltlap::bms {
namespace {

constexpr std::uint8_t kMark = 0xA5;  // neither blank pattern
constexpr std::size_t kCrcByte = kTripRecordBytes - 1;

bool blank(const TripSlot& slot) {
  for (const std::uint8_t byte : slot.bytes) {
    if (byte != slot.bytes[0]) return false;
  }
  return slot.bytes[0] == 0x00 || slot.bytes[0] == 0xFF;
}

std::uint8_t crc_of(const TripSlot& slot) {
  std::uint8_t crc = codec::kCrc8Start;
  for (std::size_t i = 0; i < kCrcByte; ++i) crc = codec::crc8_step(crc, slot.bytes[i]);
  return codec::crc8_finish(crc);
}

bool good(const TripSlot& slot) { return slot.bytes[0] == kMark && slot.bytes[kCrcByte] == crc_of(slot); }

/// Records of before the lowest bit was given to isolation keep their meaning: it is written as the highest.
std::uint32_t as_written(std::uint32_t latched) { return latched >> 1 | latched << 31; }
std::uint32_t as_latched(std::uint32_t written) { return written << 1 | written >> 31; }

TripRecord from_slot(const TripSlot& slot) {
  TripRecord record;
  std::uint32_t written = 0;
  for (unsigned i = 0; i < 4; ++i) written |= std::uint32_t{slot.bytes[1 + i]} << (8 * i);
  record.latched = as_latched(written);
  record.writing = static_cast<std::uint16_t>(slot.bytes[5] | slot.bytes[6] << 8);
  return record;
}

/// By the shorter way round.
bool later(std::uint16_t a, std::uint16_t b) { return static_cast<std::int16_t>(a - b) > 0; }

}  // namespace

TripSlot to_slot(const TripRecord& record) {
  TripSlot slot;
  slot.bytes[0] = kMark;
  const std::uint32_t written = as_written(record.latched);
  for (unsigned i = 0; i < 4; ++i) slot.bytes[1 + i] = static_cast<std::uint8_t>(written >> (8 * i));
  slot.bytes[5] = static_cast<std::uint8_t>(record.writing);
  slot.bytes[6] = static_cast<std::uint8_t>(record.writing >> 8);
  slot.bytes[kCrcByte] = crc_of(slot);
  return slot;
}

TripHistory read_slots(const TripSlot (&slots)[kTripSlots]) {
  TripHistory out;
  bool found = false;
  for (const TripSlot& slot : slots) {
    if (!good(slot)) continue;
    const TripRecord record = from_slot(slot);
    if (found && !later(record.writing, out.newest.writing)) continue;
    out.newest = record;
    out.oldest_slot = &slot == slots ? 1 : 0;
    found = true;
  }
  out.damaged = !found && !(blank(slots[0]) && blank(slots[1]));
  return out;
}

}  // namespace voltlap::bms
