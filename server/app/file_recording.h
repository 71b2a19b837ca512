#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/host/disk.h"
#include "server/sheet/recording.h"

namespace kerf::app {

// Writes a recording file while the sheet runs (form: kerf/v1/run.proto). What was appended is in the operating
// system's hands: it survives the process, not the machine. After the first failure, told once to `note`, nothing more
// is written and the sheet goes on.
class FileRecording : public sheet::RecordingSink {
 public:
  // `disk` must outlive this; `note` is called from the sheet's strand.
  FileRecording(host::Disk& disk, std::string path, std::function<void(const std::string&)> note);

  void start(const sheet::SheetConfig& config) override;
  void append(const sheet::RecordedTick& entry) override;

 private:
  void write(const std::string& bytes);
  void give_up(const Error& error);

  host::Disk& disk_;
  const std::string path_;
  const std::function<void(const std::string&)> note_;
  std::unique_ptr<host::AppendFile> file_;
};

}  // namespace kerf::app
