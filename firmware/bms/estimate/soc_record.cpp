// SPDX-License-Identifier: Apache-2.0
#include "bms/estimate/soc_record.hpp"

#include "base/crc32.hpp"
#include "base/require.hpp"

namespace voltlap::bms {
namespace {

constexpr std::uint8_t kMark = 0x5D;  // neither blank pattern; another layout has another
constexpr std::size_t kCrcByte = kSocRecordBytes - 4;
constexpr int kSocBits = 14, kBranchBits = 12, kScaleBits = 13, kFadeBits = 14;
static_assert(kMaxCells < 256, "a byte for the number of cells");

constexpr std::int64_t coarse(std::int32_t value, int bits) { return shifted(value, kUnitBits - bits); }
/// So that what a filter may hold needs no saturation.
template <class T, std::int32_t low, std::int32_t high, int bits>
constexpr bool kHolds =
    coarse(low, bits) >= std::numeric_limits<T>::min() && coarse(high, bits) <= std::numeric_limits<T>::max();
static_assert(kHolds<std::int16_t, kSocLow, kSocHigh, kSocBits>);
static_assert(kHolds<std::int16_t, -kBranchMost, kBranchMost, kBranchBits>);
static_assert(kHolds<std::uint16_t, kScaleLow, kScaleHigh, kScaleBits>);
static_assert(kHolds<std::int16_t, kFadeLow, kFadeHigh, kFadeBits>);
template <class T>
T coarse(std::int32_t value, int bits) { return static_cast<T>(coarse(value, bits)); }
std::int32_t fine(std::int32_t value, int bits) { return saturated32(std::int64_t{value} * (1 << (kUnitBits - bits))); }

std::int32_t within(std::int32_t x, std::int32_t low, std::int32_t high) {
  return x < low ? low : (x > high ? high : x);
}

std::uint32_t crc_of(const SocSlot& slot) { return crc32(slot.bytes, kCrcByte); }

void put16(SocSlot& slot, std::size_t at, unsigned value) {
  slot.bytes[at] = static_cast<std::uint8_t>(value);
  slot.bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
}
std::uint16_t get16(const SocSlot& slot, std::size_t at) {
  return static_cast<std::uint16_t>(slot.bytes[at] | slot.bytes[at + 1] << 8);
}
std::int16_t signed16(const SocSlot& slot, std::size_t at) { return static_cast<std::int16_t>(get16(slot, at)); }

std::uint32_t crc_in(const SocSlot& slot) {
  return get16(slot, kCrcByte) | std::uint32_t{get16(slot, kCrcByte + 2)} << 16;
}

bool good(const SocSlot& slot) {
  return slot.bytes[0] == kMark && slot.bytes[1] <= kMaxCells && crc_in(slot) == crc_of(slot);
}

/// By the shorter way round.
bool later(std::uint16_t a, std::uint16_t b) { return static_cast<std::int16_t>(a - b) > 0; }

void from_slot(const SocSlot& slot, SocRecord& record) {
  record.cells = slot.bytes[1];
  record.writing = get16(slot, 2);
  record.pieces = get16(slot, 4);
  for (std::size_t i = 0; i < kMaxCells; ++i) {
    const std::size_t at = kSocHeadBytes + i * kCellRecordBytes;
    record.cell[i] = {signed16(slot, at), signed16(slot, at + 2), signed16(slot, at + 4), get16(slot, at + 6),
                      signed16(slot, at + 8)};
  }
}

}  // namespace

void keep(const Config& config, const SocEstimate& state, SocRecord& record) {
  record.cells = 0;
  if (!state.valid) return;
  record.cells = config.cells_in_series;
  const std::int16_t counted = coarse<std::int16_t>(filter_soc(state.value), kSocBits);
  for (std::size_t i = 0; i < record.cells; ++i) {
    const FilteredCell& cell = state.filter.cell[i];
    if (config.soc_method != SocMethod::kEkf) {
      record.cell[i] = CellRecord{};
      record.cell[i].soc = counted;
      continue;
    }
    record.cell[i] = {coarse<std::int16_t>(cell.filter.s, kSocBits), coarse<std::int16_t>(cell.filter.v1, kBranchBits),
                      coarse<std::int16_t>(cell.filter.v2, kBranchBits),
                      coarse<std::uint16_t>(cell.filter.rho, kScaleBits),
                      coarse<std::int16_t>(cell.filter.fade, kFadeBits)};
  }
}

// BMS-083
void restore(const Config& config, const SocRecord& record, SocEstimate& state) {
  VOLTLAP_REQUIRE(!state.valid);
  if (record.cells != config.cells_in_series) return;  // nor one that knows nothing
  for (std::size_t i = 0; i < record.cells; ++i) {
    FilteredCell& cell = state.filter.cell[i];
    const CellRecord& from = record.cell[i];
    cell.filter.s = within(fine(from.soc, kSocBits), kSocLow, kSocHigh);
    cell.filter.v1 = within(fine(from.v1, kBranchBits), -kBranchMost, kBranchMost);
    cell.filter.v2 = within(fine(from.v2, kBranchBits), -kBranchMost, kBranchMost);
    cell.filter.rho = within(fine(from.scale, kScaleBits), kScaleLow, kScaleHigh);
    cell.filter.fade = within(fine(from.fade, kFadeBits), kFadeLow, kFadeHigh);
  }
  state.filter.restored = true;
}

Soc recorded_soc(const SocRecord& record) {
  if (record.cells == 0) return Soc{};
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < record.cells; ++i) sum += record.cell[i].soc;
  return reported_soc(fine(sum / record.cells, kSocBits));
}

void to_slot(const SocRecord& record, SocSlot& slot) {
  VOLTLAP_REQUIRE(record.cells <= kMaxCells);
  slot = SocSlot{};
  slot.bytes[0] = kMark;
  slot.bytes[1] = static_cast<std::uint8_t>(record.cells);
  put16(slot, 2, record.writing);
  put16(slot, 4, record.pieces);
  for (std::size_t i = 0; i < kMaxCells; ++i) {
    const std::size_t at = kSocHeadBytes + i * kCellRecordBytes;
    const CellRecord& cell = record.cell[i];
    put16(slot, at, static_cast<std::uint16_t>(cell.soc));
    put16(slot, at + 2, static_cast<std::uint16_t>(cell.v1));
    put16(slot, at + 4, static_cast<std::uint16_t>(cell.v2));
    put16(slot, at + 6, cell.scale);
    put16(slot, at + 8, static_cast<std::uint16_t>(cell.fade));
  }
  const std::uint32_t crc = crc_of(slot);
  put16(slot, kCrcByte, crc & 0xFFFFU);
  put16(slot, kCrcByte + 2, crc >> 16);
}

void read_slots(const SocSlot (&slots)[kSocSlots], SocRecord& newest, std::size_t& oldest_slot) {
  oldest_slot = 0;
  newest.cells = 0;
  bool found = false;
  for (std::size_t i = 0; i < kSocSlots; ++i) {
    if (!good(slots[i]) || (found && !later(get16(slots[i], 2), newest.writing))) continue;
    from_slot(slots[i], newest);
    oldest_slot = 1 - i;
    found = true;
  }
}

}  // namespace voltlap::bms
