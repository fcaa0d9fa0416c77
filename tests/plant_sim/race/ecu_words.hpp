// SPDX-License-Identifier: Apache-2.0
// A command receiver that hears what a test has the ECUs say.
#pragma once
#include "codec/seal.hpp"
#include "fixtures.hpp"
#include "race/actuators/command_receiver.hpp"

namespace voltlap::plant::test {

struct EcuWords {
  Car car{vtm16e(), true, 0.001};
  CommandReceiver ecus;

  /// Twice: the first frame of a message only synchronises its counter.
  template <class... Messages>
  void say(const Messages&... messages) {
    for (int i = 0; i < 2; ++i) {
      const Frame frames[] = {sealed(messages)...};
      ecus.receive(Instant::from_ms(10 * ++tick_), {frames, sizeof...(messages)}, car);
    }
  }

 private:
  template <class Message>
  Frame sealed(const Message& message) {
    Frame frame;
    can::encode(message, frame);
    sealer_.seal(frame);
    return frame;
  }

  codec::Sealer sealer_;
  std::uint32_t tick_ = 0;
};

}  // namespace voltlap::plant::test
