// SPDX-License-Identifier: Apache-2.0
// The firmware as a process of its own in lockstep with a plant: file descriptor 3 comes from it, 4 goes to it, as
// `voltlap endurance --ecu process` opens them. A reset of the board is this program started anew in its process; what
// outlives it lies in a file without a name, at 5.
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include "base/require.hpp"
#include "port/image_check.hpp"
#include "port/lockstep/lockstep_board.hpp"

namespace voltlap::port {
namespace {

constexpr int kFromPlant = 3, kToPlant = 4, kMemory = 5;
constexpr int kExitUsage = 2, kExitPlantGone = 3, kExitDefect = 70;

class PipeRig final : public Rig {
 public:
  std::size_t read(std::uint8_t* bytes, std::size_t capacity) override {
    ssize_t got = 0;
    do {
      got = ::read(kFromPlant, bytes, capacity);
    } while (got < 0 && errno == EINTR);
    if (got < 0 && errno == EBADF) refuse();
    return got > 0 ? static_cast<std::size_t>(got) : 0;
  }
  bool write(const std::uint8_t* bytes, std::size_t count) override {
    for (std::size_t done = 0; done < count;) {
      const ssize_t sent = ::write(kToPlant, bytes + done, count - done);
      if (sent < 0 && errno == EBADF) refuse();
      if (sent < 0 && errno != EINTR) return false;
      if (sent > 0) done += static_cast<std::size_t>(sent);
    }
    return true;
  }
  [[nodiscard]] bool counts() const override { return false; }
  [[nodiscard]] std::uint32_t instructions() const override { return 0; }
  [[nodiscard]] std::uint32_t stack_used() const override { return 0; }
  [[nodiscard]] std::uint32_t stack_size() const override { return 0; }
  [[noreturn]] void restart() override {
    ::execl("/proc/self/exe", "voltlap-firmware", static_cast<char*>(nullptr));
    std::fputs("voltlap-firmware: a reset of the board failed: this program cannot be started anew\n", stderr);
    std::_Exit(kExitDefect);
  }
  [[noreturn]] void end(bool good) override { std::_Exit(good ? 0 : kExitPlantGone); }

 private:
  [[noreturn]] static void refuse() {
    std::fputs(
        "voltlap-firmware: found no plant at the file descriptors 3 and 4; expected to be started by one. "
        "Use ./voltlap endurance --ecu process.\n",
        stderr);
    std::_Exit(kExitUsage);
  }
};

/// That of before a reset, or a new one.
RamNvm::Memory& lasting_memory() {
  struct stat known{};
  const bool is_there = ::fstat(kMemory, &known) == 0 && known.st_size == sizeof(RamNvm::Memory);
  if (!is_there) {
    const int file = ::memfd_create("memory of the board", 0);
    const bool made = file >= 0 && ::ftruncate(file, sizeof(RamNvm::Memory)) == 0 && ::dup2(file, kMemory) == kMemory;
    VOLTLAP_REQUIRE(made);
    if (file != kMemory) ::close(file);
  }
  void* at = ::mmap(nullptr, sizeof(RamNvm::Memory), PROT_READ | PROT_WRITE, MAP_SHARED, kMemory, 0);
  VOLTLAP_REQUIRE(at != MAP_FAILED);
  return *static_cast<RamNvm::Memory*>(at);
}

}  // namespace

/// A process has no flash of its own.
std::uint32_t image_residue() { return kImageWhole; }

LockstepBoard start_lockstep_board() {
  static PipeRig rig;
  return board_around(rig, lasting_memory());
}

}  // namespace voltlap::port

namespace voltlap {

void require_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "voltlap-firmware: defect: this does not hold: %s in %s, line %d\n", condition, file, line);
  std::_Exit(port::kExitDefect);
}

}  // namespace voltlap
