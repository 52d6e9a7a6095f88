#pragma once

#include <assimp/IOSystem.hpp>
#include <filesystem>
#include <string>
#include <utility>

#include "host/input/readable_folders.hpp"

namespace weft::io {

/// Hands files to assimp: the one that is to be read and, of those that it names, only regular
/// files below readable folders. The first refusal is kept, since assimp hides why it failed.
class AssimpFiles final : public Assimp::IOSystem {
 public:
  /// @param file    that is to be read, wherever it lies
  /// @param folders of the files that it names
  AssimpFiles(std::filesystem::path file, ReadableFolders folders)
      : file_(std::move(file)), folders_(std::move(folders)) {}

  bool Exists(const char* path) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* path, const char* mode) override;
  void Close(Assimp::IOStream* stream) override;

  /// Why a file that is there was not opened; empty: none was refused.
  const std::string& refusal() const { return refusal_; }

 private:
  std::filesystem::path file_;
  ReadableFolders folders_;
  std::string refusal_;
};

}  // namespace weft::io
