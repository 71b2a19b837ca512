#pragma once

#include <memory>
#include <string>

#include "kerf/v1/render.pb.h"
#include "server/service/api/api.h"
#include "server/service/picture/picture_view.h"
#include "server/service/picture/video_track.h"
#include "server/service/stream/flow_control.h"

namespace kerf::api {

// Holds an ImageView with its defaults filled in.
struct ImageLook {
  picture::PictureView view;
  picture::StillFormat still;  // Used by still codecs.
  render::VideoOptions video;  // Used by video codecs.
};

// Holds a decoded WatchImagesStart.
struct ImageRequest {
  stream::FlowOptions flow;
  v1::ImageCodec codec = v1::IMAGE_JPEG;  // Never unspecified.
  ImageLook look;
};

// Decodes a start. kInvalidArgument with the field; kUnavailable NO_VIDEO_CODEC.
Result<ImageRequest> decode_image_request(const v1::WatchImagesStart& start, const Limits& limits);

// Decodes a view. kInvalidArgument with the field after `prefix`: "start.view.", or "view.".
Result<ImageLook> decode_look(const v1::ImageView& message, v1::ImageCodec codec, const std::string& prefix);

}  // namespace kerf::api
