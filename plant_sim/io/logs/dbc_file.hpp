// SPDX-License-Identifier: Apache-2.0
// Frames and signals of a DBC file (KCD, SYM and ARXML as well) as far as decoding a recording needs them. cantools
// reads the file (dbc_json.hpp); here is what it found in the form that frames are decoded with.
//   value = raw * scale + offset
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/logs/bit_field.hpp"
#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

/// Raw values as bits, without sign.
struct RawRange {
  std::uint64_t first, last;
  [[nodiscard]] bool holds(std::uint64_t raw) const { return raw >= first && raw <= last; }
};

struct DbcSignal {
  enum class Kind { kUnsigned, kSigned, kHalf, kFloat, kDouble };

  std::string name, unit;
  unsigned length = 1;
  Kind kind = Kind::kUnsigned;
  double scale = 1.0, offset = 0.0;
  std::optional<double> min, max;  ///< of the value, as far as the file gives them
  std::optional<std::size_t> multiplexer;  ///< the signal of the frame on whose value it depends
  std::vector<RawRange> cases;             ///< values of the multiplexer under which it is there
  std::vector<RawRange> invalid_codes;     ///< what the file says is no measurement
  std::map<std::int64_t, std::string> value_names;  ///< by raw value, with its sign
  std::size_t line = 0;
  BitField bits;

  /// Bytes that a frame must have for it.
  [[nodiscard]] unsigned bytes() const { return bits.bytes(); }
  [[nodiscard]] bool is_integer() const { return kind == Kind::kUnsigned || kind == Kind::kSigned; }
  [[nodiscard]] std::uint64_t raw(const std::uint8_t* data) const { return bits.raw(data); }
  [[nodiscard]] double value(std::uint64_t raw) const { return value_as(kind, raw); }
  /// The value if its kind were another, such as signed where the file says unsigned.
  [[nodiscard]] double value_as(Kind other, std::uint64_t raw) const;
  /// Whether the file says that this raw value is no measurement: in its value table, in a comment, or by SAE J1939.
  [[nodiscard]] bool is_invalid_code(std::uint64_t raw) const;
  /// All ones, or either end of a signed signal, where the file's range [min|max] does not reach it: what senders put
  /// there when they have no value. A range that is the whole of the raw values says nothing.
  [[nodiscard]] bool is_end_beyond_range(std::uint64_t raw) const { return is_end_beyond_range(kind, raw); }
  [[nodiscard]] bool is_end_beyond_range(Kind as, std::uint64_t raw) const;
};

struct DbcMessage {
  std::uint32_t id = 0;  ///< bit 31 set: 29-bit identifier
  std::string name;
  std::string file;  ///< that it stands in
  unsigned length = 0;
  bool flexible = false;  ///< CAN FD
  bool j1939 = false;     ///< SAE J1939: the parameter group counts, whoever sends it
  std::optional<double> cycle_time_s;  ///< between two frames, as the file says
  std::size_t line = 0;
  std::vector<DbcSignal> signals;

  [[nodiscard]] const DbcSignal* find(std::string_view signal) const;
};

/// A frame of the file that cannot be used, and why.
struct DbcRefusal {
  std::uint32_t id = 0;  ///< bit 31 set: 29-bit identifier
  std::string name;
  std::size_t line = 0;  ///< 0: the format has no lines
  std::string found, expected, action;
};

/// What else is wrong with the file; it is mended or left out.
struct DbcNote {
  std::size_t line = 0;
  std::string text;
};

/// Parameter group number of a 29-bit identifier: without priority and source, and without the destination where it has
/// one (SAE J1939-21, 5.2).
[[nodiscard]] constexpr std::uint32_t parameter_group(std::uint32_t id) {
  const std::uint32_t format = id >> 16 & 0xFFU;
  return id >> 8 & (format < 240 ? 0x3FF00U : 0x3FFFFU);
}

class DbcFile {
 public:
  /// Throws InputError for a file that is no DBC. What is wrong with one frame hurts only who asks for that frame.
  explicit DbcFile(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::vector<DbcMessage>& messages() const { return messages_; }
  [[nodiscard]] const std::vector<DbcRefusal>& refused() const { return refused_; }
  [[nodiscard]] const std::vector<DbcNote>& notes() const { return notes_; }
  /// The frame of that identifier; of J1939 else that of its parameter group. nullptr: none.
  [[nodiscard]] const DbcMessage* find(std::uint32_t id) const;
  /// Throws InputError with file, line and reason for a frame that is there and cannot be used.
  void check_usable(std::uint32_t id) const;

 private:
  void take(const std::string& json);

  std::string path_;
  std::vector<DbcMessage> messages_;
  std::vector<DbcRefusal> refused_;
  std::vector<DbcNote> notes_;
};

/// Raw value of a signal in a frame; nothing when the frame is too short for it or when a multiplexer that it depends
/// on is on another case.
[[nodiscard]] std::optional<std::uint64_t> raw_value(const DbcMessage& message, const DbcSignal& signal,
                                                     const RecordedFrame& frame);

}  // namespace voltlap::plant
