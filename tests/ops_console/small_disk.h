#pragma once

#include <sys/mount.h>

#include <filesystem>

#include "support/temp_dir.h"

namespace rubble::ops_console {

/// A file system of 8 MB; mounted() is false where that is not permitted.
class SmallDisk {
 public:
  SmallDisk() : mounted_(::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=8m") == 0) {}
  ~SmallDisk() {
    if (mounted_) {
      ::umount2(folder_.path().c_str(), MNT_DETACH);
    }
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool mounted() const { return mounted_; }
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  test::TempDir folder_;
  bool mounted_;
};

}  // namespace rubble::ops_console
