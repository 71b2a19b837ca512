#include "server/app/file_recording.h"

#include <utility>

#include "server/wire/recording_codec.h"

namespace kerf::app {

FileRecording::FileRecording(host::Disk& disk, std::string path, std::function<void(const std::string&)> note)
    : disk_(disk), path_(std::move(path)), note_(std::move(note)) {}

void FileRecording::start(const sheet::SheetConfig& config) {
  Result<std::unique_ptr<host::AppendFile>> file = disk_.create_file(path_);
  if (!file) {
    give_up(file.error());
    return;
  }
  file_ = std::move(file).value();
  write(wire::encode_recording_header(config, wire::build_name()));
}

void FileRecording::append(const sheet::RecordedTick& entry) {
  write(wire::encode_recorded_tick(entry));
}

void FileRecording::write(const std::string& bytes) {
  if (!file_) return;
  if (const Status written = file_->append(bytes); !written) give_up(written.error());
}

void FileRecording::give_up(const Error& error) {
  file_.reset();
  note_("recording " + path_ + " stopped: " + error.message);
}

}  // namespace kerf::app
