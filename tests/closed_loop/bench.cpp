// SPDX-License-Identifier: Apache-2.0
#include "bench.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace voltlap::plant::test {

void LoopBench::tick() {
  bus_.begin_tick(tick_);
  for (int i = 0; i < 10; ++i) car.step(pedals.brake);
  car.renew(0.01);
  const Instant now = Instant::from_ms(now_ms());
  tx_.clear();
  frames_.send(now, car, pedals, switches, tx_);
  FrameView answers = bus_.exchange(tx_);
  if (loop.loses) {
    heard_.clear();
    std::copy_if(answers.begin(), answers.end(), std::back_inserter(heard_),
                 [this](const Frame& frame) { return !loop.loses(frame); });
    answers = {heard_.data(), heard_.size()};
  }
  commands.receive(now, answers, car);
  ++tick_;
}

void LoopBench::run_for(double seconds) {
  for (long i = std::lround(seconds * 100.0); i > 0; --i) tick();
}

void LoopBench::drive_off(double seconds) {
  switches.shutdown_closed = true;
  pedals = {0.0, 1.0};
  run_for(0.5);
  switches.ts_on = true;
  run_for(2.0);
  switches.ts_on = false;
  run_for(2.0);
  switches.ready_to_drive = true;
  run_for(0.5);
  switches.ready_to_drive = false;
  pedals = {1.0, 0.0};
  run_for(seconds);
}

}  // namespace voltlap::plant::test
