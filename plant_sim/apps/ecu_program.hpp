// SPDX-License-Identifier: Apache-2.0
// The firmware as another program in lockstep with this one: the image of a microcontroller in QEMU, or a host process.
// Any image of firmware/examples/ will do; one that asks for a configuration gets the car's.
#pragma once
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "apps/child_process.hpp"
#include "apps/firmware_loop.hpp"
#include "apps/pipe.hpp"
#include "io/bus/stream_bus.hpp"
#include "race/report/run_result.hpp"

namespace voltlap::plant {

struct EcuOptions {
  std::string where = "inside";  ///< inside | qemu | process
  std::string image;             ///< empty: the one that the project builds
  bool count_instructions = false;

  /// --ecu, --image and --count-instructions.
  CLI::Option* add(CLI::App& command);
  [[nodiscard]] bool outside() const { return where != "inside"; }
};

class EcuProgram {
 public:
  /// Starts it and hands it the car's configuration. Throws InputError that says what to install or to build.
  EcuProgram(const EcuOptions& options, const bms::Config& bms, const master::Config& master);
  EcuProgram(const EcuProgram&) = delete;
  EcuProgram& operator=(const EcuProgram&) = delete;

  [[nodiscard]] StreamBus& bus() { return *bus_; }
  /// The run is over. Throws InputError when the program does not end as it should.
  void end();
  /// Where the firmware ran and what it took, in lines that end.
  [[nodiscard]] std::string summary() const;
  [[nodiscard]] EcuResult result() const;

 private:
  [[nodiscard]] ChildProgram program() const;
  void check_greeting(const port::Greeting& greeting, const bms::Config& bms) const;
  [[nodiscard]] std::string what_became_of_it();

  EcuOptions options_;
  bool image_is_named_;
  FirmwareLoop inside_;  ///< for the node that an image does not have
  Pipe to_ecu_, from_ecu_;
  std::unique_ptr<ChildProcess> child_;
  std::unique_ptr<StreamBus> bus_;
  bool own_config_ = false, other_sources_ = false;
};

}  // namespace voltlap::plant
