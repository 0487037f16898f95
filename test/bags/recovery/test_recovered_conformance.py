# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The recovery of the files of the conformance tests of MCAP: whatever they hold is kept."""

from __future__ import annotations

from bags.mcap_conformance import cases, CONTENTS, Contents
from mcap.reader import make_reader
import pytest

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.recovered import Recovered


def topics_of(contents: Contents) -> dict[str, tuple]:
    """Return encoding, metadata and schema of each topic, which gets a slash as in ROS."""
    schemas = {schema.id: (schema.name, schema.encoding, schema.data)
               for schema in contents.schemas}
    return {f'/{channel.topic}': (channel.message_encoding, channel.metadata,
                                  schemas.get(channel.schema_id))
            for channel in contents.channels}


@pytest.mark.slow
@pytest.mark.parametrize('name', CONTENTS)
def test_all_messages_attachments_and_metadata_are_kept(name, tmp_path):
    """In every combination of chunks, indexes, summaries, and bytes after the fields."""
    contents = CONTENTS[name]
    topics = topics_of(contents)
    for case in cases():
        if case.contents != contents:
            continue
        path, new = tmp_path / f'{case.name}.mcap', tmp_path / case.name
        path.write_bytes(case.data)
        total: Recovered = recover(path, new)
        assert not total.damaged, (case.name, total.notes)
        assert total.messages == len(contents.messages) and not total.messages_lost
        with open(new / f'{case.name}_0.mcap', 'rb') as file:
            reader = make_reader(file, validate_crcs=True)
            messages = list(reader.iter_messages(log_time_order=False))
            assert [m for *_, m in messages] == list(contents.messages), case.name
            for schema, channel, _ in messages:
                assert topics[channel.topic] == (
                    channel.message_encoding, channel.metadata,
                    schema and (schema.name, schema.encoding, schema.data)), case.name
            assert list(reader.iter_attachments()) == list(contents.attachments), case.name
            assert [item for item in reader.iter_metadata() if item.name not in (
                'recovery', 'rosbag2')] == list(contents.metadata), case.name
