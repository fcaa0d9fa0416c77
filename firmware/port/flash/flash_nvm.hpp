// SPDX-License-Identifier: Apache-2.0
// The records of the nvm seam in two areas of flash. An area is a head, entries for trips, entries for the state of
// charge; each entry is written once, behind the one before it, with a CRC-32 over all of it as its last word. What the
// supply cuts off is no entry, and the one before it counts.
//
//   area   head 16 B | kTripEntries x trip entry 32 B | as many entries of the state of charge as there is room for
//   entry  mark, record and slot, length (4 B) | bytes, padded with 0xFF | CRC-32 over all before it
//
// Only prepare() erases. It copies what counts into the other area, whose head is written last: until that is whole,
// the area before it counts. Entries are never written over. The one behind the last may have been begun and cut off,
// and read as blank all the same: the first write of a start makes it a broken one with zeros, which every flash
// takes at any time (RM0440 3.3.7), and goes behind it.
#pragma once
#include "port/flash/flash.hpp"
#include "port/nvm.hpp"

namespace voltlap::port {

struct NvmCounts {
  std::uint32_t written = 0;  ///< records whole in the memory
  std::uint32_t refused = 0;  ///< by kBusy and kFull
  std::uint32_t failed = 0;   ///< entries that the flash did not take
  std::uint32_t moved = 0;    ///< areas erased and filled anew
};

class FlashNvm final : public Nvm {
 public:
  static constexpr std::size_t kTripBytesMost = 24;
  static constexpr std::size_t kSocBytesMost = 1464;  ///< bms::SocSlot of 144 cells, to a whole chunk
  static constexpr std::size_t kTripEntries = 64;
  static constexpr std::size_t kUnitsPerStep = 16;  ///< 0.26 ms of an STM32F4, 1.3 ms of an STM32G4

  /// `soc_ahead`: prepare() sees to it that so many records of the state of charge fit until the next one, or as many
  /// as an area holds. An endurance writes some 150.
  FlashNvm(Flash& flash, std::size_t soc_ahead) : flash_(flash), soc_ahead_(soc_ahead) {}

  bool prepare() override;
  void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) override;
  /// When the last entry for the state of charge is reached, what stands in the memory is voided: an old charge is
  /// worse than none.
  NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) override;
  NvmResult step() override;

  [[nodiscard]] const NvmCounts& counts() const { return counts_; }
  /// Entries left for this record.
  [[nodiscard]] std::size_t left(NvmRecord record) const;

 private:
  struct Region {
    std::size_t first;  ///< byte of the area
    std::size_t entry_bytes;
    std::size_t entries;
  };
  enum class Entry : std::uint8_t { kBlank, kWhole, kBroken };
  struct Seen {
    Entry entry;
    std::size_t slot;
    std::size_t length;  ///< 0: voids the record
  };

  [[nodiscard]] Region region(NvmRecord record) const;
  [[nodiscard]] bool read_head(std::size_t area, std::uint32_t& sequence);
  [[nodiscard]] bool write_head(std::size_t area, std::uint32_t sequence);
  [[nodiscard]] Seen look(std::size_t area, NvmRecord record, std::size_t index);
  [[nodiscard]] bool find(std::size_t area, NvmRecord record, std::size_t slot, std::size_t& index, Seen& seen);
  [[nodiscard]] bool some_broken(std::size_t area, NvmRecord record);
  [[nodiscard]] std::size_t first_free(std::size_t area, NvmRecord record);
  [[nodiscard]] bool move_to(std::size_t area, std::uint32_t sequence);
  [[nodiscard]] bool copy(std::size_t from, std::size_t to, NvmRecord record);
  [[nodiscard]] bool program_units(std::size_t offset, const std::uint8_t* bytes, std::size_t count);
  std::size_t compose(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count);
  NvmResult append(NvmRecord record, std::size_t size);
  NvmResult refuse(NvmResult why);
  [[nodiscard]] bool break_entry(std::size_t area, NvmRecord record, std::size_t index);
  void close_doubtful(NvmRecord record);

  Flash& flash_;
  std::size_t soc_ahead_;
  NvmCounts counts_{};
  bool usable_ = false;
  bool trips_unknown_ = false;  ///< the memory is not blank, and nobody knows what stood in it
  std::size_t active_ = 0;
  std::size_t next_[kNvmRecords] = {};
  bool doubtful_[kNvmRecords] = {};  ///< the next entry may have been begun before this start
  std::uint8_t entry_[kSocBytesMost + 8] = {};   ///< being written by step()
  std::uint8_t small_[kTripBytesMost + 8] = {};
  std::size_t pending_at_ = 0, pending_done_ = 0, pending_size_ = 0;
};

}  // namespace voltlap::port
