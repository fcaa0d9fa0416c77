// SPDX-License-Identifier: Apache-2.0
#include "apps/ecu_board.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <thread>

#include "apps/firmware_header.hpp"
#include "apps/master_header.hpp"
#include "apps/run_recorder.hpp"
#include "can_dbc/tables.hpp"
#include "core/errors.hpp"
#include "port/source_numbers.hpp"

namespace voltlap::plant {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEmulator = "qemu-system-arm";
constexpr const char* kBoard = "mps2-an386";
constexpr const char* kFromPlant = "/dev/fd/3";
constexpr const char* kToPlant = "/dev/fd/4";
constexpr std::chrono::milliseconds kEndWithin{2000}, kLook{5};

std::string on_path(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "" : path;
  while (!rest.empty()) {
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const fs::path found = fs::path(rest.substr(0, colon)) / name;
    if (::access(found.c_str(), X_OK) == 0) return found.string();
    rest.remove_prefix(std::min(colon + 1, rest.size()));
  }
  throw InputError("--ecu qemu", fmt::format("no {} on the PATH", kEmulator), "QEMU for ARM, 7.2 or later",
                   "Install it (Debian: apt-get install qemu-system-arm)");
}

std::string default_image(const std::string& where) {
  if (where == "qemu") return VOLTLAP_PROJECT_FOLDER "/build/cortex-m4/images/driven_by_plant.elf";
  return (fs::read_symlink("/proc/self/exe").parent_path() / "voltlap-firmware").string();
}

/// An ELF for an ARM of 32 bits: what QEMU can load, told before it prints its registers.
void check_elf(const std::string& image) {
  std::array<char, 20> head{};
  std::ifstream(image, std::ios::binary).read(head.data(), head.size());
  const std::string_view begin(head.data(), 6);
  constexpr char kArm = 40;  // e_machine
  if (begin == std::string_view("\x7f" "ELF\x01\x01", 6) && head[18] == kArm && head[19] == 0) return;
  throw InputError("--image", fmt::format("{}, which is no ELF for a Cortex-M", image),
                   fmt::format("an image for the board {}", kBoard),
                   "./voltlap image builds them: IMAGE is the file that ends with .elf");
}

std::string image_of(const EcuOptions& options) {
  const bool named = !options.image.empty();
  const std::string image = named ? options.image : default_image(options.where);
  if (fs::is_regular_file(image)) {
    if (options.where == "qemu") check_elf(image);
    return image;
  }
  const char* remedy = named ? "Check the name"
                       : options.where == "qemu"
                           ? "Build it: ./voltlap image"
                           : "Build it: ./voltlap endurance does, by hand it is the target voltlap-firmware";
  throw InputError(named ? "--image" : "--ecu " + options.where, "no file " + image, "the firmware, built", remedy);
}

template <class Config>
std::span<const std::byte> bytes_of(const Config& config) {
  static_assert(std::is_trivially_copyable_v<Config>);
  return std::as_bytes(std::span(&config, 1));
}

}  // namespace

EcuBoard::EcuBoard(EcuOptions options, const bms::Config& bms, const master::Config& master, BoardNodes nodes)
    : options_(std::move(options)),
      image_is_named_(!options_.image.empty()),
      bms_(bms),
      master_(master),
      nodes_(nodes),
      stream_({.to_ecu = to_ecu_.write_end(),
               .from_ecu = from_ecu_.read_end(),
               .interrupted = interrupted,
               .what_became_of_it = [this] { return what_became_of_it(); }}) {
  if (options_.count_instructions && options_.where != "qemu") {
    throw InputError("--count-instructions", "--ecu " + options_.where, "--ecu qemu",
                     "Instructions of a microcontroller are counted where one is emulated");
  }
  options_.image = image_of(options_);
  ChildProgram start = program();
  start.files = {to_ecu_.read_end(), from_ecu_.write_end()};
  const char* one = nodes.bms && nodes.master ? "" : nodes.bms ? ", BMS" : ", master";
  child_ = std::make_unique<ChildProcess>(options_.where + one, start);
  to_ecu_.close_read_end();
  from_ecu_.close_write_end();
}

void EcuBoard::meet() {
  try {
    greet();
  } catch (const BusFailure& error) {
    throw InputError("--ecu " + options_.where, fmt::format("{} that does not start: {}", options_.image, error.what()),
                     options_.where == "qemu" ? "an image of this firmware for the board mps2-an386"
                                              : "a program of this firmware",
                     options_.where == "qemu"
                         ? "Build it again: ./voltlap image"
                         : "Leave --image out: the built one is bin/voltlap-firmware of the build folder");
  }
}

void EcuBoard::greet() {
  const port::Greeting& greeting = stream_.await_greeting();
  check_greeting(greeting);
  own_config_ = greeting.bms_config_bytes == 0;
  other_sources_ = greeting.node_sources != port::kNodeSources;
  if (!own_config_) stream_.configure(bytes_of(bms_), bytes_of(master_), port::kConfigLayout, nodes_);
}

void EcuBoard::reset() {
  stream_.reset();
  greet();
}

void EcuBoard::kill() { child_->signal(SIGKILL); }

std::string EcuBoard::image() const { return fs::path(options_.image).filename().string(); }

ChildProgram EcuBoard::program() const {
  if (options_.where == "process") return {options_.image, {}};
  ChildProgram out{on_path(kEmulator),
                   {"-M", kBoard, "-display", "none", "-monitor", "none", "-serial", "none", "-parallel", "none",
                    "-semihosting-config",
                    fmt::format("enable=on,target=native,arg=image,arg={},arg={}{}", kFromPlant, kToPlant,
                                options_.count_instructions ? ",arg=count" : ""),
                    "-kernel", options_.image}};
  if (options_.count_instructions) {
    out.arguments.insert(out.arguments.end(), {"-icount", "shift=0,sleep=off"});
  }
  return out;
}

void EcuBoard::check_greeting(const port::Greeting& greeting) const {
  const std::string place = "image " + options_.image;
  if (greeting.has_bms != 0 && bms_.cells_in_series > greeting.cells_max) {
    throw InputError(place, fmt::format("memory for {} cells", greeting.cells_max),
                     fmt::format("the {} of the car", bms_.cells_in_series),
                     fmt::format("Build one: ./voltlap image --cells {}", bms_.cells_in_series));
  }
  if (greeting.node_sources != port::kNodeSources && !image_is_named_) {
    throw InputError(place, fmt::format("firmware of the sources {:08x}", greeting.node_sources),
                     fmt::format("that of {:08x}, as in this program", port::kNodeSources),
                     options_.where == "qemu" ? "Build it again: ./voltlap image"
                                              : "Build the target voltlap-firmware");
  }
  if (greeting.bms_config_bytes == 0) return check_owner(greeting);
  const bool fits = greeting.config_layout == port::kConfigLayout && greeting.bms_config_bytes == sizeof(bms::Config) &&
                    greeting.master_config_bytes == sizeof(master::Config);
  if (!fits) {
    throw InputError(place,
                     fmt::format("a configuration of {} and {} bytes, layout {:08x}", greeting.bms_config_bytes,
                                 greeting.master_config_bytes, greeting.config_layout),
                     fmt::format("one of {} and {} bytes, layout {:08x}, as this program has it", sizeof(bms::Config),
                                 sizeof(master::Config), port::kConfigLayout),
                     "It is of other sources than this program: build both again (./voltlap image)");
  }
  if (bms_.temperature_sensors > greeting.temperatures_max) {
    throw InputError(place, fmt::format("memory for {} thermistors", greeting.temperatures_max),
                     fmt::format("the {} of the car", bms_.temperature_sensors),
                     "Build one with more: ./voltlap image --cells N makes room for as many thermistors as cells");
  }
}

/// An image with a configuration of its own is driven in the car whose configuration that is, and in no other.
void EcuBoard::check_owner(const port::Greeting& greeting) const {
  const std::uint32_t bms = configuration_number(bms_), master = configuration_number(master_);
  const bool other_bms = greeting.has_bms != 0 && greeting.bms_number != 0 && greeting.bms_number != bms;
  const bool other_master =
      greeting.has_master != 0 && greeting.master_number != 0 && greeting.master_number != master;
  if (!other_bms && !other_master) return;
  const std::string car(greeting.car, strnlen(greeting.car, sizeof greeting.car));
  const std::string cells =
      greeting.has_bms != 0 ? fmt::format(", {} cells in series", greeting.cells_in_series) : "";
  throw InputError("image " + options_.image,
                   fmt::format("the configuration of '{}'{} ({:08x}-{:08x})", car, cells, greeting.bms_number,
                               greeting.master_number),
                   fmt::format("that of the car of this run, {} cells in series ({:08x}-{:08x})",
                               bms_.cells_in_series, bms, master),
                   "Build its own: ./voltlap image with the same --vehicle and --set; or leave --image out: the "
                   "built one takes every car");
}

void EcuBoard::end() {
  try {
    stream_.stop();
  } catch (const BusFailure& error) {
    throw InputError("--ecu " + options_.where, error.what(), "an end when the run is over",
                     "The result stands; see what the program printed");
  }
  for (auto waited = std::chrono::milliseconds(0); waited < kEndWithin; waited += kLook) {
    if (child_->has_just_ended()) return;
    std::this_thread::sleep_for(kLook);
  }
}

std::string EcuBoard::what_became_of_it() {
  for (auto waited = std::chrono::milliseconds(0); waited < kEndWithin; waited += kLook) {
    if (child_->has_just_ended()) {
      return fmt::format("({}, process {}) {}", child_->name(), child_->pid(), child_->end_text());
    }
    std::this_thread::sleep_for(kLook);
  }
  return fmt::format("({}, process {}) has closed its stream", child_->name(), child_->pid());
}

}  // namespace voltlap::plant
