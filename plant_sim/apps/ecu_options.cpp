// SPDX-License-Identifier: Apache-2.0
#include "apps/ecu_options.hpp"

#include "apps/flag_checks.hpp"

namespace voltlap::plant {

CLI::Option* EcuOptions::add(CLI::App& command) {
  CLI::Option* ecu =
      command
          .add_option("--ecu", where,
                      "Where the firmware runs. inside: in this process; qemu: the image of a Cortex-M4 in QEMU; "
                      "process: a process on a pipe. The frames are the same")
          ->check(one_of({"inside", "qemu", "process"}))
          ->capture_default_str();
  command.add_option("--image", image, "With --ecu qemu an ELF, with --ecu process a program; default: the built one")
      ->type_name("FILE")
      ->needs(ecu);
  command
      .add_flag("--count-instructions", count_instructions,
                "With --ecu qemu: count what every step of the firmware takes")
      ->needs(ecu);
  return ecu;
}

}  // namespace voltlap::plant
