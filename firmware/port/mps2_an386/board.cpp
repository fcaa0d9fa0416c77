// SPDX-License-Identifier: Apache-2.0
// ARM MPS2 with the FPGA image AN386, as QEMU emulates it: a Cortex-M4 without a CAN controller. Bus and clock are the
// plant's, at the other end of two files that the command line names, by semihosting:
//
//   qemu-system-arm -M mps2-an386 -kernel IMAGE.elf
//                   -semihosting-config enable=on,target=native,arg=IMAGE,arg=IN,arg=OUT
//
// with the word `count` behind OUT where QEMU runs with -icount shift=0: an instruction is a nanosecond there.
#include "port/board.hpp"

#include "port/cortex_m/stack.hpp"
#include "port/lockstep/lockstep_board.hpp"
#include "port/mps2_an386/reset.hpp"
#include "port/mps2_an386/semihosting.hpp"

namespace voltlap::port {
namespace {

constexpr std::uint32_t kExitGood = 0, kExitUsage = 2, kExitPlantGone = 3;
constexpr std::uint32_t kReadBinary = 1, kWriteBinary = 5;
constexpr std::uint32_t kNone = 0xFFFF'FFFFU;

/// CMSDK timer 0 (Application Note 386, table 4-1; Cortex-M System Design Kit TRM, 3.3): counts down with 25 MHz.
struct Timer {
  volatile std::uint32_t ctrl, value, reload, interrupt;
};
Timer& timer() { return *reinterpret_cast<Timer*>(0x4000'0000U); }
constexpr std::uint32_t kTimerEnable = 1;
constexpr std::uint32_t kInstructionsPerCount = 40;  // 1 GHz of instructions over 25 MHz

void start_timer() {
  timer().reload = kNone;
  timer().value = kNone;
  timer().ctrl = kTimerEnable;
}

/// A word of the command line, which is cut into words in place.
struct Word {
  const char* text = nullptr;
  std::uint32_t length = 0;
};

bool is(const Word& word, const char* text) {
  for (std::uint32_t i = 0; i < word.length; ++i) {
    if (text[i] == '\0' || word.text[i] != text[i]) return false;
  }
  return text[word.length] == '\0';
}

Word next_word(char*& at) {
  while (*at == ' ') ++at;
  Word word{at, 0};
  while (*at != ' ' && *at != '\0') ++at;
  word.length = static_cast<std::uint32_t>(at - word.text);
  if (*at == ' ') *at++ = '\0';
  return word;
}

class SemihostingRig final : public Rig {
 public:
  SemihostingRig() {
    char line[256];
    if (!semihosting::command_line(line, sizeof line)) refuse();
    char* at = line;
    static_cast<void>(next_word(at));  // the image
    const Word in = next_word(at), out = next_word(at);
    if (in.length == 0 || out.length == 0) refuse();
    in_ = semihosting::open(in.text, in.length, kReadBinary);
    out_ = semihosting::open(out.text, out.length, kWriteBinary);
    if (in_ == kNone || out_ == kNone) refuse();
    counts_ = is(next_word(at), "count");
    if (counts_) start_timer();
  }

  std::size_t read(std::uint8_t* bytes, std::size_t capacity) override {
    return capacity - semihosting::read(in_, bytes, static_cast<std::uint32_t>(capacity));
  }
  bool write(const std::uint8_t* bytes, std::size_t count) override {
    return semihosting::write(out_, bytes, static_cast<std::uint32_t>(count)) == 0;
  }
  [[nodiscard]] bool counts() const override { return counts_; }
  [[nodiscard]] std::uint32_t instructions() const override {
    return counts_ ? kInstructionsPerCount * (kNone - timer().value) : 0;
  }
  [[nodiscard]] std::uint32_t stack_used() const override { return port::stack_used(); }
  [[nodiscard]] std::uint32_t stack_size() const override { return port::stack_size(); }
  [[noreturn]] void restart() override { reset_processor(); }
  [[noreturn]] void end(bool good) override { semihosting::exit(good ? kExitGood : kExitPlantGone); }

 private:
  [[noreturn]] static void refuse() {
    semihosting::write_text(
        "voltlap image: two files are expected on the command line, from the plant and to it; "
        "`voltlap endurance --ecu qemu` gives them.\n");
    semihosting::exit(kExitUsage);
  }

  std::uint32_t in_ = kNone, out_ = kNone;
  bool counts_ = false;
};

/// Outside of the memory that an image's budget counts, and that a start-up clears: memory.ld.
__attribute__((section(".nvm"))) RamNvm::Memory nvm_memory;

}  // namespace

LockstepBoard start_lockstep_board() {
  static SemihostingRig rig;
  return board_around(rig, nvm_memory);
}

}  // namespace voltlap::port
