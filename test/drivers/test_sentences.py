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

"""Each kind of sentence: what it gives, and why it gives nothing."""

from __future__ import annotations

from hypothesis import given, strategies as st
import pytest

from heading_intercompare.drivers.sentences import heading_of, identify, Name, Rejected


@pytest.mark.parametrize('text, heading_deg', [
    (b'HEHDT,218.53,T', 218.53),
    (b'HEHDT,0,T', 0.0),
    (b'HEHDT,360.00,T', 0.0),
    (b'HEHDT,-0.0,T', 0.0),
    (b'GPHDT, 12.3,T', 12.3),
    (b'HETHS,77.52,A', 77.52),
    (b'PASHR,123816.80,312.95,T,-0.83,-0.42,-0.01,0.234,0.224,0.298,2,1', 312.95),
    (b'PASHR,,312.95,T,,,,,,,0,0', 312.95),
    (b'PASHR,ATT,183944.8,100.9,+000.42,-000.13,0.0009,0.0019,0', 100.9),
    (b'PSXN,23,0.35,-1.74,218.26,0.58', 218.26),
    (b'PUHAW,UVH,-4.87,-6.04,219.2', 219.2),
    (b'HCHDG,98.3,0.0,E,12.6,W', 85.7),
    (b'HEHDG,311.2,1.7,W,2.0,E', 311.5),
    (b'SDHDG,229.5,,,1.5,E', 231.0),
    (b'SDHDG,229.5,0.0,,1.5,E', 231.0),
    (b'SDHDG,359.0,,,1.5,E', 0.5),
    (b'SDHDG,1.0,,,1.5,W', 359.5),
])
def test_a_sentence_gives_its_heading(text, heading_deg):
    assert heading_of(text) == pytest.approx(heading_deg, abs=1e-12)


@pytest.mark.parametrize('text, reason', [
    (b'IIHDT,,T', 'empty_heading'),
    (b'IIHDT,  ,T', 'empty_heading'),
    (b'HEHDT,nan,T', 'bad_field'),
    (b'HEHDT,inf,T', 'bad_field'),
    (b'HEHDT,1e2,T', 'bad_field'),
    (b'HEHDT,1_0,T', 'bad_field'),
    (b'HEHDT,12.3.4,T', 'bad_field'),
    (b'HEHDT,\xd9\xa1,T', 'bad_field'),
    (b'HEHDT,360.01,T', 'out_of_range'),
    (b'HEHDT,-180.01,T', 'out_of_range'),
    (b'HEHDT,400,T', 'out_of_range'),
    (b'HEHDT,12.3,M', 'not_true'),
    (b'HEHDT,12.3,', 'not_true'),
    (b'HEHDT,12.3', 'too_few_fields'),
    (b'HETHS,77.5,V', 'invalid_mode.V'),
    (b'HETHS,,V', 'invalid_mode.V'),
    (b'HETHS,77.5,E', 'invalid_mode.E'),
    (b'HETHS,77.5,M', 'invalid_mode.M'),
    (b'HETHS,77.5,S', 'invalid_mode.S'),
    (b'HETHS,77.5,', 'invalid_mode.other'),
    (b'HETHS,77.5,EM', 'invalid_mode.other'),
    (b'HETHS,,A', 'empty_heading'),
    (b'HETHS,77.5', 'too_few_fields'),
    (b'PASHR,123816.80,312.95,M,-0.83', 'not_true'),
    (b'PASHR,123816.80,,T,-0.83', 'empty_heading'),
    (b'PASHR,ATT,183944.8,,1,2', 'empty_heading'),
    (b'PASHR,ATT,183944.8', 'too_few_fields'),
    (b'PSXN,23,0.35,-1.74,,0.58', 'empty_heading'),
    (b'PSXN,23,0.35,-1.74', 'too_few_fields'),
    (b'PUHAW,UVH,-4.87,-6.04,', 'empty_heading'),
    (b'HCHDG,98.3,0.0,E,,', 'no_variation'),
    (b'HCHDG,98.3,,,,', 'no_variation'),
    (b'HCHDG,,,,1.0,E', 'empty_heading'),
    (b'HCHDG,98.3,,,1.0,', 'bad_field'),
    (b'HCHDG,98.3,,,1.0,N', 'bad_field'),
    (b'HCHDG,98.3,x,E,1.0,E', 'bad_field'),
    (b'HCHDG,98.3,,,181.0,E', 'bad_field'),
    (b'HCHDG,98.3,,', 'too_few_fields'),
])
def test_a_sentence_without_a_heading_says_why(text, reason):
    with pytest.raises(Rejected) as caught:
        heading_of(text)
    assert caught.value.reason == reason


@pytest.mark.parametrize('text, name', [
    (b'HEHDT,1,T', Name('HDT', 'HE')), (b'GNTHS,1,A', Name('THS', 'GN')),
    (b'HCHDG,', Name('HDG', 'HC')), (b'PASHR,010203,', Name('PASHR', '')),
    (b'PASHR,ATT,', Name('PASHR', '')), (b'PSXN,23,', Name('PSXN,23', '')),
    (b'PUHAW,UVH,', Name('PUHAW,UVH', ''))])
def test_a_heading_sentence_is_identified(text, name):
    assert identify(text) == name


@pytest.mark.parametrize('text', [
    b'', b'HEHDT', b'HEHDM,1,M', b'XHEHDT,1,T', b'HDT,1,T', b'HEROT,1,A', b'CCHEQ,HDT',
    b'PSXN,20,1,0,0,0', b'PSXN,22,1,2', b'PSXN', b'PASHR,POS,1,2', b'PASHR', b'PUHAW,XYZ,1',
    b'PUHAW', b'AIVDM,1,1,,A', b'\xff\xfe\xfd\xfc\xfb,'])
def test_another_sentence_is_not_a_heading(text):
    assert identify(text) is None


@given(st.integers(0, 35999))
def test_every_heading_with_two_decimals_is_read_as_python_reads_it(hundredths):
    text = f'{hundredths // 100}.{hundredths % 100:02d}'
    assert heading_of(f'HEHDT,{text},T'.encode()) == float(text)


@given(st.sampled_from([b'HEHDT,', b'HETHS,', b'HCHDG,', b'PASHR,1', b'PASHR,ATT,', b'PSXN,23,',
                        b'PUHAW,UVH,']),
       st.lists(st.one_of(st.binary(max_size=4), st.sampled_from([b'1', b'T', b'A', b'361'])),
                max_size=7))
def test_any_fields_give_a_heading_in_range_or_a_reason(start, fields):
    try:
        assert 0.0 <= heading_of(start + b','.join(fields)) < 360.0
    except Rejected as rejected:
        assert rejected.reason
