// SPDX-License-Identifier: Apache-2.0
// A board as an image sees it: all of its seams. Each board's port defines start_board(); an image is linked with one.
#pragma once
#include "port/can.hpp"
#include "port/cells.hpp"
#include "port/clock.hpp"
#include "port/gpio.hpp"
#include "port/nvm.hpp"
#include "port/restart.hpp"
#include "port/second_clock.hpp"
#include "port/watchdog.hpp"

namespace voltlap::port {

struct Board {
  Can& can;
  Clock& clock;
  Gpio& gpio;
  Nvm& nvm;
  Watchdog& watchdog;
  Cells* cells = nullptr;  ///< of a board that measures them itself; else monitors on the bus do
  Restart* restart = nullptr;  ///< of a board that a tester may start anew
  SecondClock* second_clock = nullptr;  ///< of a part that has another oscillator; else nothing is compared
};

/// Brings clocks, pins and bus up; once, first thing in main(). The memory is not prepared and the watchdog sleeps.
[[nodiscard]] Board start_board();

}  // namespace voltlap::port
