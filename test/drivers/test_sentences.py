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

from heading_intercompare.drivers.sentences import (
    Compass,
    find_time,
    heading_of,
    identify,
    Name,
    Rejected,
)

#: The headers of Unicore and NovAtel; the name of the log goes into the second.
UNIHEADING = b'#UNIHEADINGA,97,GPS,FINE,2190,365174000,0,0,18,12;'
HEADING = b'#%b,COM1,0,39.5,FINESTEERING,1622,422892.200,02040000,f9bf,6521;'


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
    (b'PTNL,AVR,181059.6,+149.4688,Yaw,+0.0134,Tilt,,,60.191,3,2.5,6', 149.4688),
    (b'PTNL,AVR,212604.30,-52.1531,Yaw,-0.08,Tilt,0.1,Roll,12.575,14,1.4,16', 307.8469),
    (b'PTNL,VHD,030556.00,093098,187.718,-22.138,-76.929,-5.015,0.033,0.006,3,07,2.4,M', 187.718),
    (b'PSAT,HPR,235410.50,89.58,3.35,,N', 89.58),
    (b'PSSN,HRP,142657.80,061222,152.236,,-0.708,0.084,,0.181,21,2,2.400,E', 152.236),
    (b'GNHPR,081212.00,341.48,-00.64,000.00,4,46,0.00,0999', 341.48),
    (b'KSXT,20190909084745.00,116.2,40.1,68.4,299.22,-67.03,190.28,0.022,,1,3,46,28', 299.22),
    (b'PFEC,GPatt,294.7,-02.5,+00.4', 294.7),
    (b'PRDID,-2.06,4.81,37.62', 37.62),
    (b'GPTRA,063027.30,101.78,071.19,-00.00,4,10,0.00,0004', 101.78),
    (b'GPYBM,SN10009927,085454.00,+31.28,+121.15,23.588,179.843,-0.818,0.024,-0.018,0.064,0.030,'
     b'3463100.193,609429.443,,,1,4,42,200,,1.024,37,', 179.843),
    (b'PQTMTAR,1,165331.000,4,,0.232438,-4.2,0.0,83.99,0.1,,0.3,30', 83.99),
    (b'PASHR,HPR,021745.90,302.15390,1.90221,,0.0065,0.0000,0,2,0.900,1.2', 302.1539),
    (b'PASHR,AT2,183944.8,100.9,+000.42,-000.13,0.0009,0.0019,0,6,1,1,1,2.1', 100.9),
    (b'GPPAT,183944.00,2117.1,N,15753.2,W,12.3,100.9,0.42,-0.13,0.0009,0.0019,0', 100.9),
    (b'PHOCT,01,192621.400,T,00,080.378,T,-000.106,T,-03.105,T,+00.220,T,+00.08', 80.378),
    (b'PHOCT,01,192621.400,E,00,080.378,T,-000.106,T,-03.105,T,+00.220,T,+00.08', 80.378),
    (b'PSBGB,1,000344.000,0,3.529,-12.821,6.122,0.101,0.098,10.117,1,1,0.004,0.050,2', 6.122),
    (b'VNINS,125176.941097,2332,8206,+082.014,+000.014,+001.063,+51.51,-000.11', 82.014),
    (b'VNINS,125176.941097,2332,000E,-082.014,+000.014,+001.063,+51.51,-000.11', 277.986),
    (UNIHEADING + b'SOL_COMPUTED,NARROW_INT,1.0000,90.2500,10.0,0,0.1,0.2,"0",20', 90.25),
    (HEADING % b'HEADINGA' + b'SOL_COMPUTED,L1_INT,5.92,12.5,-1.3,0,0.2,0.3,"0",18', 12.5),
    (HEADING % b'HEADING2A' + b'SOL_COMPUTED,NARROW_INT,0.9,178.3,-1.3,0,0.2,0.3', 178.3),
    (HEADING % b'DUALANTENNAHEADINGA' + b'SOL_COMPUTED,NARROW_INT,-1.0,255.5,0.0,0', 255.5),
    (HEADING % b'INSPVAA' + b'2209,490558.0,51.1,-114.0,1080.3,0,0,0,-0.2,0.3,157.9,'
     b'INS_SOLUTION_GOOD', 157.9),
    (HEADING % b'INSPVAXA' + b'INS_SOLUTION_GOOD,INS_PSRSP,51.1,-114.0,1063.8,-16.2,0,0,0,1.13,'
     b'-0.16,135.7,0.1', 135.7),
    (HEADING % b'INSATTA' + b'2209,490558.0,-0.3,0.3,157.9,INS_SOLUTION_FREE', 157.9),
    (HEADING % b'INSATTXA' + b'INS_SOLUTION_GOOD,INS_PSRSP,1.13,-0.16,135.7,0.1', 135.7),
    (b'%INSPVASA,2209,490558.0;2209,490558.0,51.1,-114.0,1080.3,0,0,0,-0.2,0.3,157.9,'
     b'INS_SOLUTION_GOOD', 157.9),
    (b'%INSATTSA,2209,490065.0;2209,490065.0,-0.3,0.3,158.0,INS_SOLUTION_GOOD', 158.0),
    (b'HCHDG,98.3,0.0,E,12.6,W', 85.7),
    (b'HEHDG,311.2,1.7,W,2.0,E', 311.5),
    (b'SDHDG,229.5,,,1.5,E', 231.0),
    (b'SDHDG,229.5,0.0,,1.5,E', 231.0),
    (b'SDHDG,359.0,,,1.5,E', 0.5),
    (b'SDHDG,1.0,,,1.5,W', 359.5),
    (b'VDVHW,98.3,T,96.1,M,5.2,N,9.6,K', 98.3),
    (b'VDVHW,98.3,T,,M,5.2,N,9.6,K', 98.3),
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
    (b'PTNL,AVR,181059.6,+149.4,Yaw,+0.1,Tilt,,,60.1,0,2.5,6', 'invalid_quality'),
    (b'PTNL,AVR,,,,,,,,,,,', 'invalid_quality'),
    (b'PTNL,AVR,181059.6,+149.4,Yaw', 'too_few_fields'),
    (b'PTNL,VHD,030556.00,093098,187.7,1,1,1,1,1,0,07,2.4,M', 'invalid_quality'),
    (b'PSAT,HPR,235410.50,89.58,3.35,,G', 'invalid_quality'),
    (b'PSAT,HPR,235410.50,,,,N', 'empty_heading'),
    (b'PSSN,HRP,142657.80,061222,,,,,,,21,0,2.4,E', 'invalid_quality'),
    (b'PSSN,HRP,142657.80,061222,0.0,,0.0,,,,21,0,2.4,E', 'invalid_quality'),
    (b'GNHPR,081212.00,0.00,0.00,0.00,0,0,0.00,0999', 'invalid_quality'),
    (b'KSXT,20190909084745.00,116.2,40.1,68.4,0.00,0,190.28,0.022,,3,0,46,28', 'invalid_quality'),
    (b'PFEC,GPatt,,,', 'empty_heading'),
    (b'PRDID,-2.06,4.81', 'too_few_fields'),
    (b'GPTRA,030158.40,0.00,0.00,0.00,0,00,0.00,0000', 'invalid_quality'),
    (b'GPYBM,SN1,085454.00,1,2,3,179.8,-0.8,0,0,0,0,0,0,,,4,0,42,200,,1.0,37,', 'invalid_quality'),
    (b'PQTMTAR,1,124907.000,6,,1.729,-1.316,-0.713,84.34,0.146,0.296,0.045,00', 'invalid_quality'),
    (b'PQTMTAR,1,160443.350,1,,0.000,,,,,,,23', 'invalid_quality'),
    (b'PASHR,HPR,021745.90,,,,,,,,,', 'empty_heading'),
    (b'PASHR,AT2,183944.8,100.9,+000.42,-000.13,0.0009,0.0019,1,6', 'invalid_quality'),
    (b'GPPAT,183944.00,2117.1,N,15753.2,W,12.3,100.9,0.42,-0.13,0,0,1', 'invalid_quality'),
    (b'PHOCT,01,000201.000,E,00,356.592,E,+000.225,E,+00.039,E,+00.023,T', 'invalid_quality'),
    (b'PHOCT,01,000201.000,T,00,356.592,I,+000.225,E,+00.039,E,+00.023,T', 'invalid_quality'),
    (b'PSBGB,1,000344.000,0,3.529,-12.821,6.122,0.1,0.1,10.1,0,0,0.004', 'invalid_quality'),
    (b'PSBGB,1,000344.000,1,3.529,-12.821,6.122,0.1,0.1,10.1,1,2,0.004', 'invalid_quality'),
    (b'VNINS,224159.474991,2048,8085,-149.042,+013.6,+010.9,+40.1,-88.2', 'invalid_quality'),
    (b'VNINS,333811.902862,1694,0004,+009.500,-004.754,-000.225,+32.9', 'invalid_quality'),
    (UNIHEADING + b'INSUFFICIENT_OBS,NONE,0.0,0.0,0.0,0.0,0.0,0.0,"",0', 'invalid_quality'),
    (UNIHEADING + b'SOL_COMPUTED,NONE,0.0,0.0,0.0,0.0,0.0,0.0,"",0', 'invalid_quality'),
    (HEADING % b'INSPVAA' + b'1748,502500.7,0,0,0,0,0,0,0,0,0,INS_ALIGNING', 'invalid_quality'),
    (HEADING % b'INSATTA' + b'2209,4.0,0,0,157.9,INS_HIGH_VARIANCE', 'invalid_quality'),
    (HEADING % b'INSATTXA' + b'INS_ALIGNMENT_COMPLETE,INS_PSRSP,1,0,135.7', 'invalid_quality'),
    (HEADING % b'HEADINGA' + b'SOL_COMPUTED,L1_INT,5.92', 'too_few_fields'),
    (b'HCHDG,98.3,0.0,E,,', 'no_variation'),
    (b'HCHDG,98.3,,,,', 'no_variation'),
    (b'HCHDG,,,,1.0,E', 'empty_heading'),
    (b'HCHDG,98.3,,,1.0,', 'bad_field'),
    (b'HCHDG,98.3,,,1.0,N', 'bad_field'),
    (b'HCHDG,98.3,x,E,1.0,E', 'bad_field'),
    (b'HCHDG,98.3,,,181.0,E', 'bad_field'),
    (b'HCHDG,98.3,,', 'too_few_fields'),
    (b'HCHDM,98.3,M', 'no_variation'),
    (b'HCHDM,98.3,T', 'bad_field'),
    (b'HCHDM,,M', 'empty_heading'),
    (b'VDVHW,,T,96.1,M,5.2,N,9.6,K', 'no_variation'),
    (b'VDVHW,,T,,M,5.2,N,9.6,K', 'empty_heading'),
    (b'VDVHW,98.3,,96.1,M,5.2,N,9.6,K', 'not_true'),
])
def test_a_sentence_without_a_heading_says_why(text, reason):
    with pytest.raises(Rejected) as caught:
        heading_of(text)
    assert caught.value.reason == reason


@pytest.mark.parametrize('text, heading_deg', [
    (b'HCHDM,98.3,M', 95.8), (b'HCHDM,1.0,M', 358.5), (b'VDVHW,,T,96.5,M,5.2,N,9.6,K', 94.0),
    (b'VDVHW,98.3,T,,M,5.2,N,9.6,K', 98.3), (b'HCHDG,98.3,1.0,E,,', 96.8),
    (b'HCHDG,98.3,,,2.0,E', 100.3), (b'HEHDT,98.3,T', 98.3)])
def test_a_stated_variation_serves_where_a_sentence_has_none(text, heading_deg):
    assert heading_of(text, Compass(-2.5)) == pytest.approx(heading_deg, abs=1e-12)


@pytest.mark.parametrize('text, place', [
    (b'GPTRA,063027.30,101.78', (1, 'hhmmss')), (b'PASHR,021745.90,302.1,T', (1, 'hhmmss')),
    (b'PASHR,ATT,183944.8,100.9', (0, 'hhmmss')), (b'PASHR,AT2,183944.8,100.9', (0, 'hhmmss')),
    (b'PASHR,HPR,021745.90,302.1', (2, 'hhmmss')), (b'GNTHS,1.0,A', (0, 'hhmmss')),
    (b'PHOCT,01,192621.400,T,00,080.378,T', (2, 'hhmmss')),
    (b'PHOCT,01,192621.400,E,00,080.378,T', (0, 'hhmmss')),
    (b'PSBGB,1,000344.000,2,3.5', (2, 'hhmmss')), (b'PSBGB,1,000344.000,3,3.5', (0, 'hhmmss')),
    (b'KSXT,20190909084745.00,116.2', (1, 'yyyymmddhhmmss')),
    (HEADING % b'HEADINGA' + b'SOL_COMPUTED', (0, 'week')),
    (HEADING % b'INSPVAA' + b'2209,490558.0', (10, 'week'))])
def test_the_field_of_the_time_unless_the_sentence_calls_it_invalid(text, place):
    assert find_time(identify(text), text) == place


@pytest.mark.parametrize('text, name', [
    (b'HEHDT,1,T', Name('HDT', 'HE')), (b'GNTHS,1,A', Name('THS', 'GN')),
    (b'HCHDG,', Name('HDG', 'HC')), (b'PASHR,010203,', Name('PASHR', '')),
    (b'PASHR,ATT,', Name('PASHR', '')), (b'PSXN,23,', Name('PSXN,23', '')),
    (b'PUHAW,UVH,', Name('PUHAW,UVH', '')), (b'PTNL,AVR,', Name('PTNL,AVR', '')),
    (b'PRDID,1,', Name('PRDID', '')), (b'KSXT,1,', Name('KSXT', '')),
    (b'KAHDT,1,T', Name('HDT', 'KA')),
    (b'GPHPR,1', Name('HPR', 'GP')), (b'#HEADINGA,COM1,', Name('HEADINGA', '')),
    (b'%INSATTSA,1,', Name('INSATTSA', '')), (b'PASHR,HPR,1,2', Name('PASHR,HPR', '')),
    (b'PASHR,AT2,1,2', Name('PASHR,AT2', '')), (b'PHOCT,01,1', Name('PHOCT', '')),
    (b'BDTRA,1,', Name('TRA', 'BD')), (b'VNINS,1,', Name('INS', 'VN'))])
def test_a_heading_sentence_is_identified(text, name):
    assert identify(text) == name


@pytest.mark.parametrize('text', [
    b'', b'HEHDT', b'HEHDM', b'XHEHDT,1,T', b'HDT,1,T', b'HEROT,1,A', b'CCHEQ,HDT',
    b'PSXN,20,1,0,0,0', b'PSXN,22,1,2', b'PSXN', b'PASHR,POS,1,2', b'PASHR', b'PUHAW,XYZ,1',
    b'PUHAW', b'PTNL,GGK,1', b'PTNL,AVR', b'PGHDT,1,T', b'PSAT,GBS,1', b'PIXSE,ATITUD,1,2',
    b'#BESTPOSA,COM1,0', b'HEADINGA,COM1,0', b'AIVDM,1,1,,A', b'\xff\xfe\xfd\xfc\xfb,'])
def test_another_sentence_is_not_a_heading(text):
    assert identify(text) is None


@given(st.integers(0, 35999))
def test_every_heading_with_two_decimals_is_read_as_python_reads_it(hundredths):
    text = f'{hundredths // 100}.{hundredths % 100:02d}'
    assert heading_of(f'HEHDT,{text},T'.encode()) == float(text)


@given(st.sampled_from([b'HEHDT,', b'HETHS,', b'HCHDG,', b'HCHDM,', b'VDVHW,', b'PASHR,1',
                        b'PASHR,ATT,', b'PSXN,23,', b'PUHAW,UVH,', b'PTNL,AVR,',
                        b'PSAT,HPR,', b'GNHPR,', b'#HEADINGA,']),
       st.lists(st.one_of(st.binary(max_size=4), st.sampled_from([b'1', b'T', b'A', b'361'])),
                max_size=7))
def test_any_fields_give_a_heading_in_range_or_a_reason(start, fields):
    try:
        assert 0.0 <= heading_of(start + b','.join(fields)) < 360.0
    except Rejected as rejected:
        assert rejected.reason
