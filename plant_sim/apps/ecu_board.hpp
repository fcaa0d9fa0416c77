// SPDX-License-Identifier: Apache-2.0
// One board of a car as another program in lockstep with this one: the image of a microcontroller in QEMU, or a host
// process. Any image of firmware/examples/ will do; one that asks for a configuration gets the car's.
#pragma once
#include <memory>
#include <string>

#include "apps/child_process.hpp"
#include "apps/ecu_options.hpp"
#include "apps/pipe.hpp"
#include "bms/config.hpp"
#include "io/bus/board_stream.hpp"
#include "master/config.hpp"

namespace voltlap::plant {

class EcuBoard {
 public:
  /// Starts the program. Throws InputError that says what to install or to build.
  EcuBoard(EcuOptions options, const bms::Config& bms, const master::Config& master, BoardNodes nodes = {});
  EcuBoard(const EcuBoard&) = delete;
  EcuBoard& operator=(const EcuBoard&) = delete;

  /// Waits for its greeting and hands it the car's configuration; once, before the first tick. Throws InputError for
  /// what is no image of this firmware, or one that the car does not fit.
  void meet();
  /// The board loses its supply for a moment: its processor begins anew, and is handed the configuration again.
  void reset();
  /// It is gone for good.
  void kill();
  /// The run is over. Throws InputError when the program does not end as it should.
  void end();

  [[nodiscard]] BoardStream& stream() { return stream_; }
  [[nodiscard]] const BoardStream& stream() const { return stream_; }
  [[nodiscard]] const EcuOptions& options() const { return options_; }
  /// File name of the image.
  [[nodiscard]] std::string image() const;
  /// The image has a configuration of its own, and is not of this program's firmware.
  [[nodiscard]] bool own_config() const { return own_config_; }
  [[nodiscard]] bool other_sources() const { return other_sources_; }

 private:
  [[nodiscard]] ChildProgram program() const;
  void greet();
  void check_greeting(const port::Greeting& greeting) const;
  void check_owner(const port::Greeting& greeting) const;
  [[nodiscard]] std::string what_became_of_it();

  EcuOptions options_;
  bool image_is_named_;
  bms::Config bms_;
  master::Config master_;
  BoardNodes nodes_;
  Pipe to_ecu_, from_ecu_;
  std::unique_ptr<ChildProcess> child_;
  BoardStream stream_;
  bool own_config_ = false, other_sources_ = false;
};

}  // namespace voltlap::plant
