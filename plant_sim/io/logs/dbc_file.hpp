// SPDX-License-Identifier: Apache-2.0
// Frames and signals of a DBC file, as far as decoding a recording needs them: start, length, byte order, sign or
// floating point, scale, offset, range and simple multiplexing.
//   value = raw * scale + offset
// Start bit: of an Intel signal (@1) its lowest bit, of a Motorola signal (@0) its highest; bit 8 b + k is bit k of
// byte b.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/can_frame.hpp"

namespace voltlap::plant {

struct DbcSignal {
  enum class Mux { kNone, kSwitch, kCase };
  enum class Kind { kUnsigned, kSigned, kFloat, kDouble };

  std::string name;
  unsigned start = 0, length = 1;
  bool big_endian = false;
  Kind kind = Kind::kUnsigned;
  double scale = 1.0, offset = 0.0;
  double min = 0.0, max = 0.0;  ///< both 0: none given
  Mux mux = Mux::kNone;
  std::uint64_t mux_case = 0;  ///< of kCase: value of the frame's switch under which it is there
  std::string unit;
  std::size_t line = 0;

  /// Bytes that a frame must have for it.
  [[nodiscard]] unsigned bytes() const;
  [[nodiscard]] std::uint64_t raw(const Frame& frame) const;
  [[nodiscard]] double value(std::uint64_t raw) const;
  /// The raw value by which senders say "not available": all ones, of a signed signal either end of its range.
  /// Signals below 8 bits have none.
  [[nodiscard]] bool is_invalid_code(std::uint64_t raw) const;
};

struct DbcMessage {
  std::uint32_t id = 0;  ///< bit 31 set: 29-bit identifier
  std::string name;
  unsigned length = 0;
  std::size_t line = 0;
  std::vector<DbcSignal> signals;

  [[nodiscard]] const DbcSignal* find(std::string_view signal) const;
  /// The signal that chooses between the others; nullptr when there is none.
  [[nodiscard]] const DbcSignal* mux_switch() const;
};

class DbcFile {
 public:
  /// Throws InputError with file and line for what cannot be read exactly: a frame given twice, a signal name twice
  /// in a frame, a signal beyond its frame, nested multiplexing, a broken line. Nothing is half-read.
  explicit DbcFile(const std::string& path);

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] const std::vector<DbcMessage>& messages() const { return messages_; }
  [[nodiscard]] const DbcMessage* find(std::uint32_t id) const;

 private:
  void add_message(std::string_view text, std::size_t line);
  void add_signal(std::string_view text, std::size_t line);
  void add_value_type(std::string_view text, std::size_t line);
  void add_long_name(std::string_view text, std::size_t line);
  [[nodiscard]] std::string place(std::size_t line) const;

  std::string path_;
  std::vector<DbcMessage> messages_;
  bool skipping_ = false;  ///< signals of the pseudo frame that holds unused ones
};

/// Value of a signal in a frame; nothing when the frame is too short for it or its multiplexer is on another case.
[[nodiscard]] std::optional<std::uint64_t> raw_value(const DbcMessage& message, const DbcSignal& signal,
                                                     const Frame& frame);

}  // namespace voltlap::plant
