"""Options of channels to servers."""

# A message may hold the exact state of half a million vertices. Proxies set in the environment are ignored, because
# Kerf servers are near. Short backoffs find a restarted server soon.
CHANNEL_OPTIONS = [
    ("grpc.max_receive_message_length", 256 << 20),
    ("grpc.enable_http_proxy", 0),
    ("grpc.max_reconnect_backoff_ms", 2000),
]
