// SPDX-License-Identifier: Apache-2.0
// The seam between a node and the pins of its board: what it drives and what it senses, by what they mean. Which pin,
// which polarity, which transistor is behind them only the board knows.
#pragma once
#include <cstdint>

namespace voltlap::port {

/// What a board drives. All are off from reset until the first `set`, and off again after a reset of any kind: an
/// isolation relay that is not driven is open.
enum class Drive : std::uint8_t {
  kAirPlus = 0,
  kAirMinus = 1,
  kPrecharge = 2,
  kShutdownRelay = 3,  ///< the BMS's own contact in the shutdown circuit (EV.7.2): on while no fault asks it open
  kRtdSound = 4,       ///< ready-to-drive sound (EV.4.11)
};
inline constexpr std::uint8_t kDrives = 5;

/// What a board senses. `true` is what the name says, whatever the level at the pin.
enum class Sense : std::uint8_t {
  kShutdownClosed = 0,
  kAirPlusAux = 1,  ///< auxiliary contact: the relay is closed
  kAirMinusAux = 2,
  kPrechargeAux = 3,
  kTsOnButton = 4,
  kRtdButton = 5,
  kResetButton = 6,
  kChargeSwitch = 7,
};
inline constexpr std::uint8_t kSenses = 8;

class Gpio {
 public:
  /// At once; nothing for what this board does not drive.
  virtual void set(Drive what, bool on) = 0;
  /// The level now, not debounced; false for what this board does not sense, which is the state that opens.
  [[nodiscard]] virtual bool get(Sense what) const = 0;

 protected:
  ~Gpio() = default;
};

}  // namespace voltlap::port
