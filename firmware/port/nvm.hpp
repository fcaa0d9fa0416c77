// SPDX-License-Identifier: Apache-2.0
// The seam between a node and the memory that outlives its supply: records of bytes, two slots each, as
// app/trip_keeper.hpp and app/soc_keeper.hpp read them before the first tick and write them in turns.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port {

/// What is kept. Trips are few, short and must never be lost; the state of charge comes often and may be skipped.
enum class NvmRecord : std::uint8_t { kTrips = 0, kSoc = 1 };
inline constexpr std::size_t kNvmRecords = 2;
inline constexpr std::size_t kNvmSlots = 2;  ///< of each record

enum class NvmResult : std::uint8_t {
  kOk = 0,      ///< written, or (longer records) taken and being written by step()
  kBusy = 1,    ///< the writing before is not finished; nothing was changed
  kFull = 2,    ///< no blank memory left for this record until the next prepare(); nothing was changed
  kFailed = 3,  ///< the memory did not take it or reads back otherwise; what stood before still counts
};

/// A write may be cut off by the loss of the supply at any byte: the slot then reads as it did before, or, where it had
/// never been whole, as bytes that no record's CRC takes. It never reads as a mixture that a CRC takes.
class Nvm {
 public:
  /// Brings the memory in order; may take seconds (erasing). Before the first tick and before the watchdog runs, with
  /// open contactors. False when it cannot be used: writes fail, and reads are blank, of trips unknown bytes where
  /// something stood there.
  virtual bool prepare() = 0;
  /// The slot as it was last written whole; bytes of 0xFF when it never was.
  virtual void read(NvmRecord record, std::size_t slot, std::uint8_t* bytes, std::size_t count) = 0;
  /// Takes a copy of the bytes. Trips are in the memory when this returns, in less than a millisecond.
  virtual NvmResult write(NvmRecord record, std::size_t slot, const std::uint8_t* bytes, std::size_t count) = 0;
  /// A bounded piece of the writing that is under way; once in every tick.
  virtual NvmResult step() = 0;

 protected:
  ~Nvm() = default;
};

}  // namespace voltlap::port
