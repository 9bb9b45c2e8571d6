#include "support/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "common/error.h"

namespace rubble::test {

namespace {

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> out;
  for (const std::string& text : texts) {
    out.push_back(const_cast<char*>(text.c_str()));
  }
  out.push_back(nullptr);
  return out;
}

std::vector<std::string> mergedEnvironment(const std::vector<std::string>& additions) {
  std::vector<std::string> merged = additions;
  for (char** entry = ::environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    const std::string name = text.substr(0, text.find('=') + 1);
    if (std::none_of(additions.begin(), additions.end(),
                     [&](const auto& a) { return a.starts_with(name); })) {
      merged.push_back(text);
    }
  }
  return merged;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments,
                           const std::vector<std::string>& environment) {
  int out[2];
  int err[2];
  RUBBLE_CHECK(::pipe2(out, O_CLOEXEC) == 0 && ::pipe2(err, O_CLOEXEC) == 0);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  const std::vector<std::string> merged = mergedEnvironment(environment);
  const int error = ::posix_spawn(&pid_, arguments.front().c_str(), &actions, nullptr,
                                  pointers(arguments).data(), pointers(merged).data());
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  ::close(err[1]);
  pipes_ = {out[0], err[0]};
  RUBBLE_CHECK(error == 0);
  pidfd_ = static_cast<int>(::syscall(SYS_pidfd_open, pid_, 0));  // glibc declares it for C only.
  RUBBLE_CHECK(pidfd_ >= 0);
}

ChildProcess::~ChildProcess() {
  if (!status_) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(pidfd_);
  for (const int fd : pipes_) {
    if (fd >= 0) {
      ::close(fd);
    }
  }
}

void ChildProcess::signal(int number) const {
  if (!status_) {
    ::kill(pid_, number);
  }
}

bool ChildProcess::readOutput(std::size_t stream) {
  char buffer[4096];
  const ssize_t n = ::read(pipes_[stream], buffer, sizeof(buffer));
  if (n > 0) {
    output_[stream].append(buffer, static_cast<std::size_t>(n));
    return true;
  }
  ::close(pipes_[stream]);
  pipes_[stream] = -1;
  return false;
}

std::optional<int> ChildProcess::wait(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!status_) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd fds[3] = {{pipes_[0], POLLIN, 0}, {pipes_[1], POLLIN, 0}, {pidfd_, POLLIN, 0}};
    if (left.count() <= 0 || ::poll(fds, 3, static_cast<int>(left.count())) == 0) {
      return std::nullopt;
    }
    for (const std::size_t stream : {0U, 1U}) {
      if (fds[stream].revents != 0) {
        readOutput(stream);
      }
    }
    if ((fds[2].revents & POLLIN) != 0) {
      int status = 0;
      ::waitpid(pid_, &status, 0);
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
  }
  for (const std::size_t stream : {0U, 1U}) {
    while (pipes_[stream] >= 0 && readOutput(stream)) {
    }
  }
  return status_;
}

}  // namespace rubble::test
