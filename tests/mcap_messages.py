"""MCAP files as the reader of MCAP's own project sees them."""

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def read(file):
    """(topic, stamp [s], message) in order, the schemas and the channels."""
    with file.open("rb") as opened:
        reader = make_reader(opened, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        messages = [
            (channel.topic, stored.log_time * 1e-9, decoded)
            for _, channel, stored, decoded in reader.iter_decoded_messages()
        ]
    channels = {channel.topic: channel for channel in summary.channels.values()}
    return messages, {topic: summary.schemas[channel.schema_id].name for topic, channel in channels.items()}, channels
