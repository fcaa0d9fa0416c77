// SPDX-License-Identifier: Apache-2.0
// decode_frames DBC RECORDING: every signal of every frame, "line identifier signal value", for the comparison with
// another decoder.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "core/errors.hpp"
#include "io/logs/can/can_recording.hpp"
#include "io/logs/dbc_file.hpp"

int main(int argc, char** argv) {
  using namespace voltlap::plant;
  if (argc != 3) return 2;
  try {
    const DbcFile dbc(argv[1]);
    CanRecording recording(argv[2]);
    RecordedFrame timed;
    while (recording.next(timed)) {
      voltlap::Frame frame;
      frame.id = timed.id;
      frame.dlc = std::min<std::uint8_t>(timed.length, 8);
      std::copy_n(timed.data, frame.dlc, frame.data);
      const DbcMessage* message = dbc.find(timed.id);
      if (message == nullptr) continue;
      for (const DbcSignal& signal : message->signals) {
        const auto raw = raw_value(*message, signal, frame);
        if (raw) fmt::print("{} {} {} {:.17g}\n", timed.line, timed.id, signal.name, signal.value(*raw));
      }
    }
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
