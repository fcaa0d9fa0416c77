// SPDX-License-Identifier: Apache-2.0
#include "apps/guarded_main.hpp"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "apps/exit_code.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

int complain(const char* text, int code) {
  std::fprintf(stderr, "voltlap: %s\n", text);
  return code;
}

/// The exit code, once what was printed has arrived; a full disk or a reader that went away is an error as well.
int with_output_flushed(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  return complain(
      "standard output: found that it does not take what is printed; expected a reader, or a disk with room. "
      "Make room, or send it elsewhere.",
      kExitInput);
}

}  // namespace

int guarded_main(int (*program)(int, char**), int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return with_output_flushed(program(argc, argv));
  } catch (const InputError& error) {
    return complain(error.what(), kExitInput);
  } catch (const OutputError& error) {
    return complain(error.what(), kExitInput);
  } catch (const std::bad_alloc&) {
    return complain("found that the memory ran out; expected an input that fits into it. Use a smaller one.",
                    kExitFault);
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return with_output_flushed(kExitInput);  // what the print function threw
    std::fprintf(stderr, "voltlap: found a defect of the program (%s). Please report it with the command line.\n",
                 error.what());
    return kExitFault;
  }
}

}  // namespace voltlap::plant
