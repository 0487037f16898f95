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

"""The files of the conformance tests of MCAP: written as the originals, and read whole."""

from __future__ import annotations

from pathlib import Path

from bags.mcap_bytes import record
from bags.mcap_conformance import Case, cases, CONTENTS, digest, extend, extended_everywhere
from mcap import records as mcap
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.attachments import parse_attachment
from heading_intercompare.bags.mcap.mcap_file import Part
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.cli import main

#: SHA-256 of `digest`. On 28 November 2026 each file had the SHA-256 and the size of the original.
DIGESTS = {
    'NoData': '5892e94ef0815f1a4f59e480ed0091709de46e54b75c14326c3ffdd08b0776b4',
    'OneSchemalessMessage': '63d2478e8019351cbf7c725acd292391192a716d6e188faed844c9f6af18838c',
    'OneMessage': '554370bf0295ac98edbcae30a217efc0cba8e2a95dd30b27e656f8ef4953c6ee',
    'OneAttachment': 'a5b5b2d9fd878cfbb4243b0ed7ad43106a0e1c9f6a4056a689a205c79eef0894',
    'OneMetadata': '771ee0953df247d8fc2a2d042897a65e872ab0e4f7511f06818915d94865d090',
    'TenMessages': 'a7e65ac78ca77067beab7b2e86dededb2fcec652e3158295606b8ac19fb00387'}


@pytest.mark.parametrize('name', CONTENTS)
def test_files_are_those_of_the_originals(name):
    """Each digest covers the name, the SHA-256 and the size of each file of an input."""
    assert digest(name) == DIGESTS[name]


@pytest.fixture(params=cases(), ids=lambda case: case.name)
def case(request) -> Case:
    return request.param


@pytest.fixture
def path(case, tmp_path) -> Path:
    path = tmp_path / f'{case.name}.mcap'
    path.write_bytes(case.data)
    return path


def read_messages(part: Part) -> list[mcap.Message]:
    """Return the messages of a file."""
    messages = []
    for block in part.blocks():
        for head, start, stop in zip(block.heads.tolist(), block.start, block.stop):
            _, _, number, sequence, log_ns, publish_ns = head
            messages.append(mcap.Message(
                channel_id=number, data=bytes(block.data[start:stop]), log_time=log_ns,
                publish_time=publish_ns, sequence=sequence))
    return messages


def test_contents_are_those_of_the_input(case, path):
    """Statistics: the counts and the span hold with and without a summary."""
    part, contents = Part(path), case.contents
    assert part.incomplete is None
    assert read_messages(part) == list(contents.messages)
    assert tuple(part.schemas.values()) == contents.schemas
    assert tuple(part.channels.values()) == contents.channels
    assert tuple(part.metadata()) == contents.metadata
    assert tuple(part.attachments()) == contents.attachments
    times = [sent.log_time for sent in contents.messages]
    assert sum(part.counts.values()) == len(times)
    assert (part.start_ns, part.end_ns) == (min(times, default=None), max(times, default=None))


def test_no_file_is_called_damaged(case, path, capsys):
    """The check finds each message, and `info` calls the bag complete."""
    check = check_bag(path)
    assert check.faults == []
    assert check.messages == len(case.contents.messages)
    assert main(['info', '--check', str(path)]) == 0
    assert 'complete: yes' in capsys.readouterr().out


@pytest.mark.parametrize('name', CONTENTS)
def test_every_record_that_may_grow_may_have_grown(name, tmp_path):
    """The originals do not extend chunks, nor the definitions in them; the specification does."""
    path = tmp_path / 'grown.mcap'
    path.write_bytes(extended_everywhere(name))
    part, contents = Part(path), CONTENTS[name]
    assert read_messages(part) == list(contents.messages)
    assert tuple(part.schemas.values()) == contents.schemas
    assert tuple(part.channels.values()) == contents.channels
    assert tuple(part.metadata()) == contents.metadata
    assert tuple(part.attachments()) == contents.attachments
    assert check_bag(path).faults == []


def test_checksum_of_an_extended_attachment_counts():
    """One bit of the data is wrong: the bytes after the checksum hide nothing."""
    attachment, = CONTENTS['OneAttachment'].attachments
    content = bytearray(extend(record(attachment))[9:])
    assert parse_attachment(bytes(content)) == attachment
    content[content.index(attachment.data)] ^= 1
    with pytest.raises(BagError, match='its checksum does not match'):
        parse_attachment(bytes(content))


@pytest.mark.parametrize('cut', range(1, 40))
def test_an_attachment_shorter_than_its_fields_is_damaged(cut):
    attachment, = CONTENTS['OneAttachment'].attachments
    with pytest.raises(BagError, match='a record of type Attachment is damaged'):
        parse_attachment(record(attachment)[9:-cut])
