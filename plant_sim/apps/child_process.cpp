// SPDX-License-Identifier: Apache-2.0
#include "apps/child_process.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr const char* kThisProgram = "/proc/self/exe";
constexpr int kCannotStart = 127;

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::vector<std::string>& arguments) : name_(std::move(name)) {
  std::vector<char*> argv = {const_cast<char*>("voltlap")};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw InputError(fmt::format("cannot start a process for {}: {}", name_, std::strerror(errno)));
  if (pid_ > 0) return;
  // A group of its own: Ctrl-C reaches the parent only, which ends the others in their order.
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(kCannotStart);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execv(kThisProgram, argv.data());
  ::_exit(kCannotStart);
}

ChildProcess::~ChildProcess() {
  if (!runs()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool ChildProcess::has_just_ended() {
  if (!runs()) return false;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
  status_ = status;
  return true;
}

void ChildProcess::signal(int number) const {
  if (runs()) ::kill(pid_, number);
}

std::optional<int> ChildProcess::exit_code() const {
  return status_ && WIFEXITED(*status_) ? std::optional(WEXITSTATUS(*status_)) : std::nullopt;
}

std::string ChildProcess::end_text() const {
  if (const auto code = exit_code()) return fmt::format("ended with exit code {}", *code);
  const int number = status_ ? WTERMSIG(*status_) : 0;
  return fmt::format("was killed by signal {} ({})", number, ::strsignal(number));
}

}  // namespace voltlap::plant
