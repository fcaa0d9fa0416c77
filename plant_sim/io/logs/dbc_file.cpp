// SPDX-License-Identifier: Apache-2.0
#include "io/logs/dbc_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>

#include "core/errors.hpp"
#include "io/line_reader.hpp"

namespace voltlap::plant {
namespace {

constexpr std::string_view kIndependentSignals = "VECTOR__INDEPENDENT_SIG_MSG";  // on no bus

/// Takes a line apart from left to right; what does not fit throws.
class Cursor {
 public:
  Cursor(std::string_view text, std::string place) : text_(text), place_(std::move(place)) {}

  std::string_view word() {
    skip_blanks();
    std::size_t end = 0;
    while (end < text_.size() && text_[end] != ' ' && text_[end] != '\t' && text_[end] != ':') ++end;
    if (end == 0) fail("a name");
    return take(end);
  }
  template <class Number>
  Number number() {
    skip_blanks();
    if (text_.starts_with('+')) text_.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
    if (error != std::errc{}) fail("a number");
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    return value;
  }
  void expect(char wanted) {
    skip_blanks();
    if (!text_.starts_with(wanted)) fail(fmt::format("\"{}\"", wanted));
    text_.remove_prefix(1);
  }
  char character() {
    if (text_.empty()) fail("a character");
    return take(1)[0];
  }
  std::string_view quoted() {
    expect('"');
    const std::size_t end = text_.find('"');
    if (end == std::string_view::npos) fail("a closing \"");
    const std::string_view out = take(end);
    text_.remove_prefix(1);
    return out;
  }
  [[nodiscard]] bool next_is(char wanted) {
    skip_blanks();
    return text_.starts_with(wanted);
  }

 private:
  void skip_blanks() {
    while (!text_.empty() && (text_[0] == ' ' || text_[0] == '\t')) text_.remove_prefix(1);
  }
  std::string_view take(std::size_t size) {
    const std::string_view out = text_.substr(0, size);
    text_.remove_prefix(size);
    return out;
  }
  [[noreturn]] void fail(const std::string& wanted) const {
    throw InputError(place_, text_.empty() ? "the end of the line" : fmt::format("\"{}\"", text_), wanted,
                     "Mend the line; nothing of this file is used as it is");
  }

  std::string_view text_;
  std::string place_;
};

/// Position of a signal's bit k (0 the lowest) in a frame.
unsigned bit_of(const DbcSignal& signal, unsigned k) {
  if (!signal.big_endian) return signal.start + k;
  // Motorola counts from the highest bit down a byte, then on from bit 7 of the next.
  const unsigned from_top = signal.length - 1 - k;
  const unsigned linear = (signal.start / 8) * 8 + (7 - signal.start % 8) + from_top;
  return (linear / 8) * 8 + (7 - linear % 8);
}

std::uint64_t mask(unsigned length) {
  return length >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << length) - 1;
}

void read_mux(std::string_view word, DbcSignal& signal, const std::string& place) {
  if (word == "M") {
    signal.mux = DbcSignal::Mux::kSwitch;
    return;
  }
  const std::string_view digits = word.substr(1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), signal.mux_case);
  if (word[0] != 'm' || error != std::errc{} || end != digits.data() + digits.size()) {
    throw InputError(place, fmt::format("multiplexing \"{}\"", word), "M or m with a number; nested is not read",
                     "Give the frame without nested multiplexing");
  }
  signal.mux = DbcSignal::Mux::kCase;
}

DbcSignal signal_of(std::string_view text, const std::string& place, std::size_t line) {
  Cursor in(text, place);
  DbcSignal out;
  out.line = line;
  out.name = in.word();
  if (!in.next_is(':')) read_mux(in.word(), out, place);
  in.expect(':');
  out.start = in.number<unsigned>();
  in.expect('|');
  out.length = in.number<unsigned>();
  in.expect('@');
  out.big_endian = in.character() == '0';
  out.kind = in.character() == '-' ? DbcSignal::Kind::kSigned : DbcSignal::Kind::kUnsigned;
  in.expect('(');
  out.scale = in.number<double>();
  in.expect(',');
  out.offset = in.number<double>();
  in.expect(')');
  in.expect('[');
  out.min = in.number<double>();
  in.expect('|');
  out.max = in.number<double>();
  in.expect(']');
  out.unit = in.quoted();
  if (out.length < 1 || out.length > 64) {
    throw InputError(place, fmt::format("a length of {} bits", out.length), "1 to 64", "Correct the signal");
  }
  return out;
}

}  // namespace

unsigned DbcSignal::bytes() const {
  return std::max(bit_of(*this, 0), bit_of(*this, length - 1)) / 8 + 1;
}

std::uint64_t DbcSignal::raw(const Frame& frame) const {
  std::uint64_t data = 0;
  if (big_endian) {
    for (const std::uint8_t byte : frame.data) data = data << 8 | byte;
    const unsigned first = (start / 8) * 8 + (7 - start % 8);  // from the top
    return data >> (64 - first - length) & mask(length);
  }
  for (unsigned k = Frame::kMaxBytes; k-- > 0;) data = data << 8 | frame.data[k];
  return data >> start & mask(length);
}

double DbcSignal::value(std::uint64_t raw) const {
  double number = 0.0;
  switch (kind) {
    case Kind::kUnsigned:
      number = static_cast<double>(raw);
      break;
    case Kind::kSigned: {
      const std::uint64_t sign = std::uint64_t{1} << (length - 1);
      number = static_cast<double>(static_cast<std::int64_t>((raw ^ sign) - sign));
      break;
    }
    case Kind::kFloat:
      number = std::bit_cast<float>(static_cast<std::uint32_t>(raw));
      break;
    case Kind::kDouble:
      number = std::bit_cast<double>(raw);
      break;
  }
  return number * scale + offset;
}

bool DbcSignal::is_invalid_code(std::uint64_t raw) const {
  constexpr unsigned kShortest = 8;
  if (length < kShortest || kind == Kind::kFloat || kind == Kind::kDouble) return false;
  if (kind == Kind::kUnsigned) return raw == mask(length);
  const std::uint64_t lowest = std::uint64_t{1} << (length - 1);
  return raw == lowest || raw == lowest - 1;
}

const DbcSignal* DbcMessage::find(std::string_view signal) const {
  const auto at =
      std::find_if(signals.begin(), signals.end(), [&](const DbcSignal& s) { return s.name == signal; });
  return at == signals.end() ? nullptr : &*at;
}

const DbcSignal* DbcMessage::mux_switch() const {
  const auto at = std::find_if(signals.begin(), signals.end(),
                               [](const DbcSignal& s) { return s.mux == DbcSignal::Mux::kSwitch; });
  return at == signals.end() ? nullptr : &*at;
}

std::string DbcFile::place(std::size_t line) const {
  return fmt::format("{}:{}", path_, line);
}

void DbcFile::add_message(std::string_view text, std::size_t line) {
  Cursor in(text, place(line));
  DbcMessage message;
  message.line = line;
  message.id = in.number<std::uint32_t>();
  message.name = in.word();
  in.expect(':');
  message.length = in.number<unsigned>();
  skipping_ = message.name == kIndependentSignals;
  if (skipping_) return;
  if (const DbcMessage* earlier = find(message.id)) {
    throw InputError(place(line),
                     fmt::format("frame 0x{:X} for the second time", message.id & ~Frame::kExtendedFlag),
                     fmt::format("each frame once (line {} has it)", earlier->line),
                     "Keep the one that the car really sends; nothing of this file is used as it is");
  }
  messages_.push_back(std::move(message));
}

void DbcFile::add_signal(std::string_view text, std::size_t line) {
  if (skipping_) return;
  if (messages_.empty()) throw InputError(place(line), "a signal", "a frame (BO_) before it", "Mend the file");
  DbcMessage& message = messages_.back();
  DbcSignal signal = signal_of(text, place(line), line);
  if (const DbcSignal* earlier = message.find(signal.name)) {
    throw InputError(place(line), fmt::format("signal {} for the second time in {}", signal.name, message.name),
                     fmt::format("each name once in a frame (line {} has it)", earlier->line),
                     "Rename or remove it; nothing of this file is used as it is");
  }
  if (signal.mux == DbcSignal::Mux::kSwitch && message.mux_switch() != nullptr) {
    throw InputError(place(line), "a second multiplexer in " + message.name, "one", "Mend the frame");
  }
  if (signal.bytes() > std::max(message.length, 1U) && message.length <= Frame::kMaxBytes) {
    throw InputError(place(line), fmt::format("signal {} that ends in byte {}", signal.name, signal.bytes() - 1),
                     fmt::format("the {} bytes of {}", message.length, message.name), "Correct one of them");
  }
  message.signals.push_back(std::move(signal));
}

/// SIG_VALTYPE_ identifier signal : 1 (float) or 2 (double)
void DbcFile::add_value_type(std::string_view text, std::size_t line) {
  Cursor in(text, place(line));
  const auto id = in.number<std::uint32_t>();
  const std::string_view name = in.word();
  in.expect(':');
  const auto type = in.number<unsigned>();
  for (DbcMessage& message : messages_) {
    if (message.id != id) continue;
    for (DbcSignal& signal : message.signals) {
      if (signal.name != name || type == 0) continue;
      const unsigned bits = type == 1 ? 32 : 64;
      if (type > 2 || signal.length != bits) {
        throw InputError(place(line), fmt::format("value type {} for {} bits", type, signal.length),
                         "1 for 32 bits or 2 for 64 bits", "Correct the line");
      }
      signal.kind = type == 1 ? DbcSignal::Kind::kFloat : DbcSignal::Kind::kDouble;
    }
  }
}

/// BA_ "SystemSignalLongSymbol" SG_ identifier short "long": names beyond 32 characters are cut where they stand.
void DbcFile::add_long_name(std::string_view text, std::size_t line) {
  Cursor in(text, place(line));
  const auto id = in.number<std::uint32_t>();
  const std::string_view name = in.word();
  for (DbcMessage& message : messages_) {
    if (message.id != id) continue;
    for (DbcSignal& signal : message.signals) {
      if (signal.name != name) continue;
      signal.name = in.quoted();
      return;
    }
  }
}

DbcFile::DbcFile(const std::string& path) : path_(path) {
  LineReader reader(path);
  std::string_view line;
  bool quoted = false;  // within a comment that runs over several lines
  while (reader.next(line)) {
    const bool within = quoted;
    if (std::count(line.begin(), line.end(), '"') % 2 != 0) quoted = !quoted;
    if (within) continue;
    const std::size_t number = reader.number();
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos) continue;
    line.remove_prefix(first);
    if (line.starts_with("BO_ ")) add_message(line.substr(4), number);
    if (line.starts_with("SG_ ")) add_signal(line.substr(4), number);
    if (line.starts_with("SIG_VALTYPE_ ")) add_value_type(line.substr(13), number);
    constexpr std::string_view kLongName = "BA_ \"SystemSignalLongSymbol\" SG_ ";
    if (line.starts_with(kLongName)) add_long_name(line.substr(kLongName.size()), number);
  }
  if (messages_.empty()) {
    throw InputError(path, "no frame (BO_)", "a DBC file", "Check that this is the file you meant");
  }
}

const DbcMessage* DbcFile::find(std::uint32_t id) const {
  const auto at = std::find_if(messages_.begin(), messages_.end(), [&](const DbcMessage& m) { return m.id == id; });
  return at == messages_.end() ? nullptr : &*at;
}

std::optional<std::uint64_t> raw_value(const DbcMessage& message, const DbcSignal& signal, const Frame& frame) {
  if (signal.bytes() > frame.dlc) return std::nullopt;
  if (signal.mux == DbcSignal::Mux::kCase) {
    const DbcSignal* chooser = message.mux_switch();
    if (chooser == nullptr || chooser->bytes() > frame.dlc || chooser->raw(frame) != signal.mux_case) {
      return std::nullopt;
    }
  }
  return signal.raw(frame);
}

}  // namespace voltlap::plant
