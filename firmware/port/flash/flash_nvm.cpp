// SPDX-License-Identifier: Apache-2.0
#include "port/flash/flash_nvm.hpp"

#include "base/crc32.hpp"

namespace voltlap::port {
namespace {

constexpr std::uint32_t kHeadMark = 0x314E'4C56U;  // "VLN1"
constexpr std::uint8_t kEntryMark = 0x6E;          // neither blank pattern
constexpr std::size_t kHeadBytes = 16, kTagBytes = 4, kCrcBytes = 4;
constexpr std::size_t kTripEntryBytes = kTagBytes + FlashNvm::kTripBytesMost + kCrcBytes;
constexpr std::size_t kSocEntryBytes = kTagBytes + FlashNvm::kSocBytesMost + kCrcBytes;
constexpr std::size_t kChunk = 16;        // bytes read at once
constexpr std::uint8_t kUnknown = 0x55;   // bytes of a trip record that nobody knows: not blank, and no CRC takes them
constexpr std::size_t kAttempts = 2;      // entries that a write tries
static_assert(kHeadBytes % kFlashUnitMost == 0 && kTripEntryBytes % kFlashUnitMost == 0);
static_assert(kSocEntryBytes % kFlashUnitMost == 0 && kSocEntryBytes % kChunk == 0 && kTripEntryBytes % kChunk == 0);

void put32(std::uint8_t* at, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}
std::uint32_t get32(const std::uint8_t* at) {
  return at[0] | std::uint32_t{at[1]} << 8 | std::uint32_t{at[2]} << 16 | std::uint32_t{at[3]} << 24;
}
void fill(std::uint8_t* bytes, std::size_t count, std::uint8_t with) {
  for (std::size_t i = 0; i < count; ++i) bytes[i] = with;
}
std::size_t index_of(NvmRecord record) { return static_cast<std::size_t>(record); }
std::size_t most(NvmRecord record) {
  return record == NvmRecord::kTrips ? FlashNvm::kTripBytesMost : FlashNvm::kSocBytesMost;
}
/// By the shorter way round.
bool later(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }
constexpr NvmRecord kRecords[kNvmRecords] = {NvmRecord::kTrips, NvmRecord::kSoc};

}  // namespace

FlashNvm::Region FlashNvm::region(NvmRecord record) const {
  if (record == NvmRecord::kTrips) return {kHeadBytes, kTripEntryBytes, kTripEntries};
  const std::size_t first = kHeadBytes + kTripEntries * kTripEntryBytes;
  const std::size_t bytes = flash_.area_bytes();
  return {first, kSocEntryBytes, bytes > first ? (bytes - first) / kSocEntryBytes : 0};
}

bool FlashNvm::read_head(std::size_t area, std::uint32_t& sequence) {
  std::uint8_t head[kHeadBytes];
  if (!flash_.read(area, 0, head, kHeadBytes)) return false;
  sequence = get32(head + 4);
  return get32(head) == kHeadMark && get32(head + 12) == crc32(head, 12);
}

bool FlashNvm::write_head(std::size_t area, std::uint32_t sequence) {
  std::uint8_t head[kHeadBytes];
  put32(head, kHeadMark);
  put32(head + 4, sequence);
  put32(head + 8, static_cast<std::uint32_t>(flash_.area_bytes()));
  put32(head + 12, crc32(head, 12));
  for (std::size_t at = 0; at < kHeadBytes; at += flash_.unit()) {
    if (!flash_.program(area, at, head + at)) return false;
  }
  return true;
}

FlashNvm::Seen FlashNvm::look(std::size_t area, NvmRecord record, std::size_t index) {
  const Region r = region(record);
  const std::size_t at = r.first + index * r.entry_bytes;
  std::uint8_t chunk[kChunk];
  std::uint32_t crc = kCrc32Start;
  bool blank = true, read = true;
  Seen seen{Entry::kBroken, 0, 0};
  std::uint8_t mark = 0, what = 0;
  for (std::size_t from = 0; from < r.entry_bytes; from += kChunk) {
    read = flash_.read(area, at + from, chunk, kChunk) && read;
    for (const std::uint8_t byte : chunk) blank = blank && byte == kFlashBlank;
    if (from == 0) {
      mark = chunk[0];
      what = chunk[1];
      seen.length = chunk[2] | std::size_t{chunk[3]} << 8;
    }
    const bool last = from + kChunk == r.entry_bytes;
    if (mark == kEntryMark) crc = crc32_step(crc, chunk, last ? kChunk - kCrcBytes : kChunk);
    if (!last) continue;
    const bool whole = get32(chunk + kChunk - kCrcBytes) == crc32_finish(crc) && mark == kEntryMark &&
                       what >> 4 == static_cast<int>(index_of(record)) && (what & 0xFU) < kNvmSlots;
    if (read && whole && seen.length <= most(record)) seen.entry = Entry::kWhole;
  }
  seen.slot = what & 0xFU;
  if (read && blank) seen.entry = Entry::kBlank;
  return seen;
}

/// The newest entry of the slot, or one behind it that voids the record.
bool FlashNvm::find(std::size_t area, NvmRecord record, std::size_t slot, std::size_t& index, Seen& seen) {
  for (index = first_free(area, record); index-- > 0;) {
    seen = look(area, record, index);
    if (seen.entry != Entry::kWhole) continue;
    if (seen.length == 0) return false;
    if (seen.slot == slot) return true;
  }
  return false;
}

bool FlashNvm::some_broken(std::size_t area, NvmRecord record) {
  for (std::size_t i = first_free(area, record); i-- > 0;) {
    if (look(area, record, i).entry == Entry::kBroken) return true;
  }
  return false;
}

/// Behind the last entry that is not blank.
std::size_t FlashNvm::first_free(std::size_t area, NvmRecord record) {
  std::size_t i = region(record).entries;
  while (i > 0 && look(area, record, i - 1).entry == Entry::kBlank) --i;
  return i;
}

bool FlashNvm::copy(std::size_t from, std::size_t to, NvmRecord record) {
  const Region r = region(record);
  std::size_t out = 0;
  bool found = false;
  for (std::size_t slot = 0; slot < kNvmSlots; ++slot) {
    std::size_t index = 0;
    Seen seen{};
    if (!find(from, record, slot, index, seen)) continue;
    found = true;
    std::uint8_t unit[kFlashUnitMost];
    for (std::size_t at = 0; at < r.entry_bytes; at += flash_.unit()) {
      if (!flash_.read(from, r.first + index * r.entry_bytes + at, unit, flash_.unit())) return false;
      if (!flash_.program(to, r.first + out * r.entry_bytes + at, unit)) return false;
    }
    if (look(to, record, out).entry != Entry::kWhole) return false;
    ++out;
  }
  if (record == NvmRecord::kTrips && !found && some_broken(from, record)) {
    if (!break_entry(to, record, out++)) return false;  // that something was cut off stays known
  }
  next_[index_of(record)] = out;
  doubtful_[index_of(record)] = false;
  return true;
}

bool FlashNvm::break_entry(std::size_t area, NvmRecord record, std::size_t index) {
  const std::uint8_t zeros[kFlashUnitMost] = {};
  const Region r = region(record);
  return flash_.program(area, r.first + index * r.entry_bytes, zeros);
}

/// Before the first write of a start.
void FlashNvm::close_doubtful(NvmRecord record) {
  const std::size_t i = index_of(record);
  if (!doubtful_[i]) return;
  doubtful_[i] = false;
  if (next_[i] < region(record).entries && !break_entry(active_, record, next_[i])) ++counts_.failed;
  ++next_[i];
}

/// Everything that counts into `area`, whose head makes it the one that counts.
bool FlashNvm::move_to(std::size_t area, std::uint32_t sequence) {
  const std::size_t from = active_;
  if (!flash_.erase(area)) return false;
  for (const NvmRecord record : kRecords) {
    if (!copy(from, area, record)) return false;
  }
  if (!write_head(area, sequence)) return false;
  active_ = area;
  ++counts_.moved;
  return true;
}

bool FlashNvm::prepare() {
  usable_ = trips_unknown_ = false;
  pending_size_ = 0;
  if (region(NvmRecord::kSoc).entries < 4) return false;  // both slots, one that voids, and one that may be skipped
  std::uint32_t sequence[kFlashAreas] = {};
  bool whole[kFlashAreas] = {};
  for (std::size_t area = 0; area < kFlashAreas; ++area) whole[area] = read_head(area, sequence[area]);
  if (!whole[0] && !whole[1]) {  // new, or nobody's
    for (std::size_t area = 0; area < kFlashAreas; ++area) {
      trips_unknown_ = trips_unknown_ || first_free(area, NvmRecord::kTrips) > 0;
    }
    next_[0] = next_[1] = 0;
    doubtful_[0] = doubtful_[1] = false;
    usable_ = flash_.erase(0);
    if (usable_ && trips_unknown_) usable_ = break_entry(0, NvmRecord::kTrips, 0);
    next_[0] = trips_unknown_ ? 1 : 0;
    usable_ = usable_ && write_head(0, 1);
    active_ = 0;
    return usable_;
  }
  active_ = whole[0] && (!whole[1] || later(sequence[0], sequence[1])) ? 0 : 1;
  for (const NvmRecord record : kRecords) {
    next_[index_of(record)] = first_free(active_, record);
    doubtful_[index_of(record)] = true;
  }
  usable_ = true;
  const std::size_t fresh = region(NvmRecord::kSoc).entries - kNvmSlots - 1;
  const std::size_t wanted = soc_ahead_ < fresh ? soc_ahead_ : fresh;
  const bool room = left(NvmRecord::kSoc) > 0 && left(NvmRecord::kSoc) >= wanted;
  if (room && left(NvmRecord::kTrips) >= kTripEntries / 2) return true;
  const std::size_t before[kNvmRecords] = {next_[0], next_[1]};
  if (!move_to(1 - active_, sequence[active_] + 1U)) {  // what stands here still counts; it goes on while it lasts
    ++counts_.failed;
    for (std::size_t i = 0; i < kNvmRecords; ++i) {
      next_[i] = before[i];
      doubtful_[i] = true;
    }
  }
  return true;
}

std::size_t FlashNvm::left(NvmRecord record) const {
  const std::size_t all = region(record).entries - (record == NvmRecord::kSoc ? 1 : 0);  // the last one voids
  const std::size_t used = next_[index_of(record)] + (doubtful_[index_of(record)] ? 1 : 0);
  return usable_ && used < all ? all - used : 0;
}

void FlashNvm::read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) {
  fill(bytes, count, kFlashBlank);
  if (!usable_) {
    if (trips_unknown_ && record == NvmRecord::kTrips) fill(bytes, count, kUnknown);
    return;
  }
  std::size_t index = 0;
  Seen seen{};
  if (find(active_, record, slot, index, seen)) {
    const Region r = region(record);
    const std::size_t length = seen.length < count ? seen.length : count;
    static_cast<void>(flash_.read(active_, r.first + index * r.entry_bytes + kTagBytes, bytes, length));
  } else if (record == NvmRecord::kTrips && some_broken(active_, record)) {
    fill(bytes, count, kUnknown);
  }
}

std::size_t FlashNvm::compose(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) {
  std::uint8_t* const out = record == NvmRecord::kTrips ? small_ : entry_;
  const std::size_t size = region(record).entry_bytes;
  fill(out, size, kFlashBlank);
  out[0] = kEntryMark;
  out[1] = static_cast<std::uint8_t>(index_of(record) << 4 | slot);
  out[2] = static_cast<std::uint8_t>(count);
  out[3] = static_cast<std::uint8_t>(count >> 8);
  for (std::size_t i = 0; i < count; ++i) out[kTagBytes + i] = bytes[i];
  put32(out + size - kCrcBytes, crc32(out, size - kCrcBytes));
  return size;
}

bool FlashNvm::program_units(std::size_t offset, const std::uint8_t* bytes, std::size_t count) {
  for (std::size_t at = 0; at < count; at += flash_.unit()) {
    if (!flash_.program(active_, offset + at, bytes + at)) return false;
  }
  return true;
}

NvmResult FlashNvm::refuse(NvmResult why) {
  ++counts_.refused;
  return why;
}

/// At once, whatever step() is at: the entries lie apart. One that the flash does not take is left behind.
NvmResult FlashNvm::append(NvmRecord record, std::size_t size) {
  const Region r = region(record);
  std::size_t& next = next_[index_of(record)];
  for (std::size_t i = 0; i < kAttempts && next < r.entries; ++i) {
    const std::size_t at = r.first + next++ * r.entry_bytes;
    if (program_units(at, small_, size)) {
      ++counts_.written;
      return NvmResult::kOk;
    }
    ++counts_.failed;
  }
  return NvmResult::kFailed;
}

NvmResult FlashNvm::write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) {
  if (!usable_ || slot >= kNvmSlots || count == 0 || count > most(record)) return NvmResult::kFailed;
  if (record == NvmRecord::kTrips) {
    if (left(record) == 0) return refuse(NvmResult::kFull);
    close_doubtful(record);
    return append(record, compose(record, slot, bytes, count));
  }
  if (pending_size_ != 0) return refuse(NvmResult::kBusy);
  const Region r = region(record);
  std::size_t& next = next_[index_of(record)];
  const bool room = left(record) > 0;
  close_doubtful(record);
  if (next >= r.entries) return refuse(NvmResult::kFull);
  pending_size_ = compose(record, slot, bytes, room ? count : 0);
  pending_at_ = r.first + next++ * r.entry_bytes;
  pending_done_ = 0;
  return room ? NvmResult::kOk : refuse(NvmResult::kFull);
}

NvmResult FlashNvm::step() {
  if (pending_size_ == 0) return NvmResult::kOk;
  const std::size_t left_bytes = pending_size_ - pending_done_;
  const std::size_t budget = kUnitsPerStep * flash_.unit();
  const std::size_t now = left_bytes < budget ? left_bytes : budget;
  if (!program_units(pending_at_ + pending_done_, entry_ + pending_done_, now)) {
    ++counts_.failed;
    pending_size_ = 0;
    return NvmResult::kFailed;
  }
  pending_done_ += now;
  if (pending_done_ < pending_size_) return NvmResult::kBusy;
  ++counts_.written;
  pending_size_ = 0;
  return NvmResult::kOk;
}

}  // namespace voltlap::port
