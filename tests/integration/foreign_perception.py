"""A perception service by somebody else: written from schemas/README.md, with nothing of ours."""

import sys

import msgpack
import zenoh

config = zenoh.Config.from_json5(f'{{mode: "client", connect: {{endpoints: ["{sys.argv[1]}"]}}}}')
with zenoh.open(config) as session:
    samples = session.declare_subscriber("doro/sim/detections")
    token = session.liveliness().declare_token("doro/perception/alive")
    for sample in samples:
        frame = msgpack.unpackb(sample.payload.to_bytes())
        for seen in frame["detections"]:
            color = seen["attributes"].get("color", "")
            seen.update(score=1, caption=f"a {color} {seen['object_type']}")
        data = msgpack.packb(frame)
        session.put("doro/captions", data, encoding="application/msgpack;doro.FrameCaptions.v1")
