/PROG  PROBEREF
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "Reference fixture";
PROG_SIZE	= 1044;
CREATE		= DATE 25-03-11  TIME 09:12:40;
MODIFIED	= DATE 25-03-11  TIME 10:02:11;
LINE_COUNT	= 4;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  UFRAME_NUM=2 ;
   2:  UTOOL_NUM=4 ;
   3:J P[10:home] 20% FINE    ;
   4:L P[1] 10mm/sec FINE    ;
/POS
P[1]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     2.9270  mm,	Y =     2.0000  mm,	Z =     1.6250  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
};
P[2:"second ]{ touch"]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     1.7750  mm,	Y =     2.8000  mm,	Z =     1.4438  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
};
P[3]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     1.3730  mm,	Y =     2.6000  mm,	Z =     3.1166  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg,
	E1=   900.000  mm
};
P[4]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     3.5270  mm,	Y =     3.2000  mm,	Z =     3.1082  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
   GP2:
	UF : 0, UT : 0,
	J1=     6.425 deg
};
P[5]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     2.8250  mm,	Y =     2.4000  mm,	Z =     4.0395  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
};
P[6]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     3.9020  mm,	Y =     5.2000  mm,	Z =     4.0353  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
};
P[7]{
   GP1:
	UF : 2, UT : 4,		CONFIG : 'N U T, 0, 0, 0',
	X =     2.0480  mm,	Y =     5.2000  mm,	Z =     4.7853  mm,
	W =  -180.000 deg,	P =     -.649 deg,	R =   -58.819 deg
};
P[10:"home"]{
   GP1:
	UF : 2, UT : 4,
	J1=     0.000 deg,	J2=   -60.000 deg,	J3=     0.000 deg,
	J4=     0.000 deg,	J5=    90.000 deg,	J6=     0.000 deg
};
/END
