// SPDX-License-Identifier: Apache-2.0
// All signals of a frame at once, for recordings of millions of frames: what a DBC file says is worked out into tables
// beforehand. Decoding allocates nothing and compares no names.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "io/logs/dbc_file.hpp"

namespace voltlap::plant {

/// Bits by the number of a signal in its message.
[[nodiscard]] constexpr std::size_t presence_words(std::size_t signals) {
  return (signals + 63) / 64;
}

class CompiledMessage {
 public:
  explicit CompiledMessage(const DbcMessage& message);

  [[nodiscard]] const DbcMessage& message() const { return *message_; }
  [[nodiscard]] std::size_t signals() const { return message_->signals.size(); }

  /// Value of each signal of the message, in the file's order; `present` has a bit for each that is there: within the
  /// frame's length and in its multiplexer's case. Values of the others are left as they were. `values` has room for
  /// signals(), `present` for presence_words(signals()).
  void decode_all(const RecordedFrame& frame, std::span<double> values, std::span<std::uint64_t> present) const;

 private:
  struct Field {
    BitField bits;
    std::uint64_t sign;  ///< its highest bit where it is signed, else 0
    double scale, offset;
    std::uint32_t number;  ///< of the signal in the message
    DbcSignal::Kind kind;
    bool wide;  ///< unsigned with 64 bits: beyond a signed number
  };
  /// Signals that are there under the same cases of the same multiplexer. A group comes after its multiplexer's own.
  struct Group {
    std::uint32_t first, count;      ///< of fields_
    std::uint32_t multiplexer;       ///< number of a signal, kNone without
    std::uint32_t range, ranges;     ///< of cases_
    BitField selector;
    unsigned bytes;  ///< that a frame must have for all of them
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  [[nodiscard]] std::vector<std::uint32_t> depths() const;
  void add_group(const std::vector<std::uint32_t>& numbers);
  [[nodiscard]] bool is_there(const Group& group, const RecordedFrame& frame,
                              std::span<const std::uint64_t> present) const;

  const DbcMessage* message_;
  std::vector<Field> fields_;
  std::vector<Group> groups_;
  std::vector<RawRange> cases_;
};

/// The frames of a file by identifier. The file must outlive it.
class DbcDecoder {
 public:
  explicit DbcDecoder(const DbcFile& file);

  /// nullptr: not in the file.
  [[nodiscard]] const CompiledMessage* find(std::uint32_t id) const {
    const std::int32_t at = id < standard_.size() ? standard_[id] : extended(id);
    return at < 0 ? nullptr : &messages_[static_cast<std::size_t>(at)];
  }
  /// The most signals that a message of the file has.
  [[nodiscard]] std::size_t most_signals() const { return most_signals_; }

 private:
  static constexpr std::size_t kStandard = 0x800;
  static constexpr std::uint32_t kExtendedFrom = RecordedFrame::kExtendedFlag;
  [[nodiscard]] std::int32_t extended(std::uint32_t id) const {
    if (const auto at = extended_.find(id); at != extended_.end()) return at->second;
    const auto group = groups_.find(parameter_group(id));
    return group == groups_.end() || id < kExtendedFrom ? -1 : group->second;
  }

  std::vector<CompiledMessage> messages_;
  std::array<std::int32_t, kStandard> standard_;
  std::unordered_map<std::uint32_t, std::int32_t> extended_;
  std::unordered_map<std::uint32_t, std::int32_t> groups_;  ///< of J1939, by parameter group
  std::size_t most_signals_ = 0;
};

}  // namespace voltlap::plant
