// SPDX-License-Identifier: Apache-2.0
// decode_frames DBC [FRAMES]: every signal of every frame, "line signal value", for the comparison with another
// decoder. FRAMES has a frame a line, "identifier data", both in hex, bit 31 of the identifier set for 29 bits; frames
// of up to 64 bytes. First come the frames of the file that are refused: "refused identifier line". Both decoders of
// the program have to agree.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/errors.hpp"
#include "io/line_reader.hpp"
#include "io/logs/dbc_decoder.hpp"
#include "io/logs/dbc_file.hpp"

namespace {

using namespace voltlap::plant;

RecordedFrame frame_of(std::string_view text) {
  RecordedFrame out;
  const std::size_t blank = text.find(' ');
  std::from_chars(text.data(), text.data() + blank, out.id, 16);
  for (std::string_view data = text.substr(blank + 1); data.size() >= 2; data.remove_prefix(2)) {
    std::from_chars(data.data(), data.data() + 2, out.data[out.length++], 16);
  }
  return out;
}

/// False when decoding one by one gives something else.
bool print(const CompiledMessage& compiled, const RecordedFrame& frame, std::size_t line) {
  const std::vector<DbcSignal>& signals = compiled.message().signals;
  std::vector<double> values(signals.size());
  std::vector<std::uint64_t> present(presence_words(signals.size()));
  compiled.decode_all(frame, values, present);
  for (std::size_t k = 0; k < signals.size(); ++k) {
    const auto raw = raw_value(compiled.message(), signals[k], frame);
    if (raw.has_value() != ((present[k / 64] >> k % 64 & 1) != 0)) return false;
    if (!raw) continue;
    const double single = signals[k].value(*raw);
    if (single != values[k] && !(std::isnan(single) && std::isnan(values[k]))) return false;
    fmt::print("{} {} {:.17g}\n", line, signals[k].name, single);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return 2;
  try {
    const DbcFile dbc(argv[1]);
    const DbcDecoder decoder(dbc);
    for (const DbcRefusal& refusal : dbc.refused()) fmt::print("refused {} {}\n", refusal.id, refusal.line);
    if (argc == 2) return 0;
    LineReader frames(argv[2]);
    std::string_view line;
    while (frames.next(line)) {
      const RecordedFrame frame = frame_of(line);
      const CompiledMessage* message = decoder.find(frame.id);
      if ((message == nullptr) != (dbc.find(frame.id) == nullptr)) return 3;
      if (message != nullptr && !print(*message, frame, frames.number())) return 3;
    }
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
